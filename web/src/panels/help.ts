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
    const keys = table().map(({ label, what }): [string, string] => [label, what]);
    const half = Math.floor((keys.length - 1) / 2);
    body.replaceChildren(
      list(GESTURES.map(([gesture, what]) => [gesture, what])),
      list(keys.slice(0, half), true),
      list(keys.slice(half), true),
    );
    element.showModal();
  };
  return { element, toggle };
}

const list = (rows: [string, string][], keys = false): HTMLElement =>
  h("dl", {}, ...rows.flatMap(([term, what]) => [h("dt", {}, keys ? h("kbd", {}, term) : term), h("dd", {}, what)]));
