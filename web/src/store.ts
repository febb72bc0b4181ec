// What the page knows, in one place: panels and the viewer read it, and are told when a part of it changes.
//
//     store.watch((s) => s.simulation?.playing, (playing) => button.update(playing));
//     store.set({ wireframe: true });

import { cutOf } from "./cut";
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
import { COLOURINGS, isField, makeScale } from "./scale";
import type { Scale } from "./scale";

/** What a tap on the object does instead of pulling it. */
export type Tool = "stiffer" | "softer" | "pin" | "force";
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
  hello: Hello | null; // what the picture is of; kept while reconnecting, so that the last one stays
  stale: boolean; // the hello is that of an earlier connection
  simulation: SimulationState | null;
  settings: Settings | null;
  recording: RecordingState | null;
  linkReport: LinkReport | null;
  progress: Progress | null; // a model is being built
  dark: boolean;
  framesDropped: number; // by this page, since it was loaded
  fieldRange: { field: FieldColouring; high: number } | null; // of the shown frame's values, and where the colours end
  selectedForce: number | null;
  tool: Tool | null;
  pointing: boolean; // a pointer is over the picture: keys mean what is under it
  refusals: number; // of commands, since the page was loaded: what a control holds may not be so
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
  stale: false,
  simulation: null,
  settings: null,
  recording: null,
  linkReport: null,
  progress: null,
  dark: false,
  framesDropped: 0,
  fieldRange: null,
  selectedForce: null,
  tool: null,
  pointing: false,
  refusals: 0,
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

/** Commands may be sent: the server has said what they are about. */
export const isOpen = ({ link, hello, stale }: Readonly<State>): boolean =>
  link.status === "open" && hello !== null && !stale;
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
  const scales = state.tool === "stiffer" || state.tool === "softer";
  const able = scales ? canScaleParts(state) : can(state, "edit");
  return able && state.scrub === null ? state.tool : null;
};
/** Solid tets show their levels whatever the surface would show. */
const shownColouring = (state: Readonly<State>): Colouring => (state.shape === "tets" ? "level" : state.colouring);

/** The colourings that this server has values for: of a recording, those that were recorded. */
export function colouringsOf(hello: Hello | null): typeof COLOURINGS {
  const recorded = hello?.recording?.colouring;
  const hasValues = hello?.capabilities?.includes("colouring") ?? false;
  return COLOURINGS.filter(
    ({ value }) => !isField(value) || (hasValues && (recorded === undefined || recorded === value)),
  );
}
/** What a scene wants to be seen of it at first; its colouring, if there are values for it. */
export function viewOf(hello: Hello): View {
  const { colouring, wireframe, cut } = hello.view;
  const offered = colouringsOf(hello).some(({ value }) => value === colouring);
  return { ...initialView, colouring: offered ? colouring : "level", wireframe, cut: cutOf(cut, hello.rest_box) };
}

/** By what the surface is coloured, and what the legend says. Null: by level, as the user wants it or because the shown frame
 * has no values of the wanted field: they have not come yet, or nobody asked for them at that moment of the past. */
export function scaleOf(state: Readonly<State>): Scale | null {
  const { hello, fieldRange } = state;
  const colouring = shownColouring(state);
  if (!hello || colouring === "level") return null;
  if (!isField(colouring)) return makeScale(colouring, hello.young_range);
  return fieldRange?.field === colouring ? makeScale(colouring, [0, fieldRange.high]) : null;
}
