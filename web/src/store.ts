// What the page knows, in one place: panels and the viewer read it, and are told when a part of it changes.
//
//     store.watch((s) => s.simulation?.playing, (playing) => button.update(playing));
//     store.set({ wireframe: true });

import type { LinkState } from "./link";
import type {
  Capability,
  Colouring,
  FieldColouring,
  Hello,
  LinkReport,
  Progress,
  RecordingState,
  Settings,
  SimulationState,
} from "./messages";
import { isField, makeScale } from "./scale";
import type { Scale } from "./scale";

/** What a tap on the object does instead of pulling it. */
export type Tool = "stiffer" | "softer" | "pin";
export type Shape = "surface" | "tets";

/** A plane that hides what is beyond it, and how far it is through the object. */
export interface Cut {
  axis: 0 | 1 | 2;
  at: number; // 0..1 of the rest box
  flip: boolean; // hide the lower side
}

/** What the user sees of the object: none of it concerns the server, but the colouring. */
export interface View {
  colouring: Colouring;
  wireframe: boolean;
  shape: Shape;
  explode: number; // 0..1: how far the tets are apart
  cut: Cut | null;
}

export interface State extends View {
  link: LinkState;
  hello: Hello | null; // of the current connection; kept while reconnecting, so that the last picture stays
  simulation: SimulationState | null;
  settings: Settings | null;
  initialSettings: Settings | null; // the first after a hello: what "reset" goes back to
  recording: RecordingState | null;
  linkReport: LinkReport | null;
  progress: Progress | null; // a model is being built
  dark: boolean;
  framesDropped: number; // by this page, since it was loaded
  fieldRange: { field: FieldColouring; high: number } | null; // where the colours end
  selectedForce: number | null;
  tool: Tool | null;
  regionSize: number; // [% of the object's diagonal] radius of what is pinned or made stiffer
  pullsByKeys: boolean; // a pull is held whose hand the arrow keys move
  scrub: number | null; // [s] simulated time of a past moment that is shown; null: live
  transparent: boolean; // pictures that the server draws have no background
}

export const initialView: View = { colouring: "level", wireframe: false, shape: "surface", explode: 0, cut: null };

export const initialState: State = {
  ...initialView,
  link: { status: "connecting" },
  hello: null,
  simulation: null,
  settings: null,
  initialSettings: null,
  recording: null,
  linkReport: null,
  progress: null,
  dark: false,
  framesDropped: 0,
  fieldRange: null,
  selectedForce: null,
  tool: null,
  regionSize: 7.5,
  pullsByKeys: false,
  scrub: null,
  transparent: false,
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
/** Something is wrong that a reset mends: the simulation has failed, or warns of a step that has not converged. */
export const wantsReset = ({ simulation }: Readonly<State>): boolean =>
  simulation !== null && (simulation.failed === true || (simulation.warning !== "" && !simulation.converged));
export const speedOf = (state: Readonly<State>): number => state.simulation?.speed ?? state.hello?.speed ?? 1;
/** What this server can do beyond pulling. */
export const can = (state: Readonly<State>, what: Capability): boolean =>
  isOpen(state) && (state.hello?.capabilities ?? []).includes(what);
/** Whether this server scales the stiffness of parts. */
export const canScaleParts = (state: Readonly<State>): boolean =>
  can(state, "edit") && state.settings?.stiffness_parts !== undefined;
/** The tool in the hand, when it can do something now. */
export const toolOf = (state: Readonly<State>): Tool | null => {
  const able = state.tool === "pin" ? can(state, "edit") : canScaleParts(state);
  return able && state.scrub === null ? state.tool : null;
};
/** Solid tets show their levels whatever the surface would show. */
export const shownColouring = (state: Readonly<State>): Colouring =>
  state.shape === "tets" ? "level" : state.colouring;

/** Null for levels, and for a field of which no values have come yet. */
export function scaleOf(state: Readonly<State>): Scale | null {
  const { hello, fieldRange } = state;
  const colouring = shownColouring(state);
  if (!hello || colouring === "level") return null;
  if (!isField(colouring)) return makeScale(colouring, hello.young_range);
  return fieldRange?.field === colouring ? makeScale(colouring, [0, fieldRange.high]) : null;
}
