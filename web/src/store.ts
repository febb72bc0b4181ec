// What the page knows, in one place: panels and the viewer read it, and are told when a part of it changes.
//
//     store.watch((s) => s.simulation?.playing, (playing) => button.update(playing));
//     store.set({ wireframe: true });

import type { LinkState } from "./link";
import type { Colouring, Hello, Progress, SimulationState } from "./protocol";

export interface State {
  link: LinkState;
  hello: Hello | null; // of the current connection; kept while reconnecting, so that the last picture stays
  simulation: SimulationState | null;
  progress: Progress | null; // a model is being built
  colouring: Colouring;
  wireframe: boolean;
  dark: boolean;
  framesDropped: number; // by this page, since it was loaded
}

export const initialState: State = {
  link: { status: "connecting" },
  hello: null,
  simulation: null,
  progress: null,
  colouring: "level",
  wireframe: false,
  dark: false,
  framesDropped: 0,
};

export class Store {
  private readonly watchers = new Set<() => void>();
  constructor(private state: State = initialState) {}

  get(): Readonly<State> {
    return this.state;
  }

  set(patch: Partial<State>): void {
    this.state = { ...this.state, ...patch };
    for (const watcher of [...this.watchers]) watcher();
  }

  /** Calls `react` now and whenever `select` gives another value (compared with Object.is). Returns the way to stop. */
  watch<T>(select: (state: Readonly<State>) => T, react: (value: T) => void): () => void {
    let last = select(this.state);
    const watcher = () => {
      const value = select(this.state);
      if (Object.is(value, last)) return;
      last = value;
      react(value);
    };
    this.watchers.add(watcher);
    react(last);
    return () => this.watchers.delete(watcher);
  }
}

export const isOpen = (state: Readonly<State>): boolean => state.link.status === "open" && state.hello !== null;
export const isPlaying = (state: Readonly<State>): boolean =>
  state.simulation?.playing ?? state.hello?.playing ?? false;
export const speedOf = (state: Readonly<State>): number => state.simulation?.speed ?? state.hello?.speed ?? 1;
