// What the hand does now when it is not the usual: a tool is in it, or a pull that the keyboard moves. Said where everybody reads it,
// with the way out.

import { toolOf } from "../store";
import type { State, Store } from "../store";
import { h } from "./dom";

const TAPS = {
  stiffer: "Tap what becomes stiffer",
  softer: "Tap what becomes softer",
  pin: "Tap what is pinned, or let go",
  force: "Tap where a force acts",
} as const;

/** One line and the word of its button; null when the hand pulls. */
export function modeOf(state: Readonly<State>): { text: string; done: string } | null {
  if (state.pullsByKeys) return { text: "Arrow keys and Page up, down pull", done: "Let go" };
  const tool = toolOf(state);
  return tool && { text: TAPS[tool], done: "Done" };
}

export function modes(store: Store, done: () => void): HTMLElement {
  const element = h("div");
  store.watch(
    (s) => modeOf(s)?.text,
    () => {
      const mode = modeOf(store.get());
      const button = mode && h("button", { type: "button", onclick: done }, mode.done);
      element.replaceChildren(
        ...(mode ? [h("div", { className: "card banner" }, h("span", {}, mode.text), button)] : []),
      );
    },
  );
  return element;
}
