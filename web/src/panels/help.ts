// The sheet of all keys and gestures.

import { GESTURES } from "../keys";
import type { Binding } from "../keys";
import { h, icon } from "./dom";

export function helpSheet(table: () => readonly Binding[]): { element: HTMLDialogElement; toggle: () => void } {
  const close = h(
    "button",
    { type: "button", className: "icon small", onclick: () => element.close(), attributes: { "aria-label": "Close" } },
    icon("close"),
  );
  const body = h("div", { className: "columns" });
  const element = h(
    "dialog",
    { className: "help", attributes: { "aria-labelledby": "help-title" } },
    h("header", {}, h("h2", { id: "help-title" }, "Keys and gestures"), close),
    body,
  );
  element.addEventListener("click", (event) => {
    if (event.target === element) element.close(); // the backdrop
  });
  element.addEventListener("keydown", (event) => {
    if (event.key === "?") element.close();
  });
  const toggle = () => {
    if (element.open) {
      element.close();
      return;
    }
    body.replaceChildren(
      list(GESTURES.map(([gesture, what]) => [gesture, what])),
      list(
        table().map(({ label, what }) => [label, what]),
        true,
      ),
    );
    element.showModal();
  };
  return { element, toggle };
}

const list = (rows: [string, string][], keys = false): HTMLElement =>
  h("dl", {}, ...rows.flatMap(([term, what]) => [h("dt", {}, keys ? h("kbd", {}, term) : term), h("dd", {}, what)]));
