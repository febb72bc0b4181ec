// A cross in the middle of the picture for those who have the keyboard alone: there the keys act that otherwise mean what is under
// the pointer. The style sheet shows it while the picture has the focus by keyboard.

import { isOpen } from "../store";
import type { State, Store } from "../store";
import { h } from "./dom";

/** Keys would act on what is in the middle. */
export const aimsAtMiddle = (state: Readonly<State>): boolean =>
  isOpen(state) && !state.hello?.recording && !state.pointing && !state.pullsByKeys && state.scrub === null;

export function aim(store: Store): HTMLElement {
  const element = h("div", { className: "aim", attributes: { "aria-hidden": "true" } });
  store.watch(aimsAtMiddle, (aims) => (element.hidden = !aims));
  return element;
}
