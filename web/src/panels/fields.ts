// Controls that the panel's groups share: a number that can be typed, with its unit and a way back to the scene's value.

import { isOpen, toolOf } from "../store";
import type { State, Store, Tool } from "../store";
import { h, throttle } from "./dom";

/** Calls `show` now, when what it shows changes, and when a command was refused: a control then holds what is not so. */
export function follow(store: Store, select: (state: Readonly<State>) => unknown, show: () => void): void {
  store.watch(select, show);
  let { refusals: seen } = store.get();
  store.watch(
    (s) => s.refusals,
    (refusals) => {
      if (refusals !== seen) show();
      seen = refusals;
    },
  );
}

export interface NumberField {
  label: string; // of the row, and with the unit of the input
  unit: string;
  spoken?: string; // the unit in words
  title?: string;
  low: number; // in the unit shown
  high: number;
  /** What is so now, in the unit shown; undefined: not known, null: no value, shown as empty. */
  now: (state: Readonly<State>) => number | null | undefined;
  /** What the scene says. */
  scene: (state: Readonly<State>) => number | null | undefined;
  change: (value: number | null) => void;
  /** May be left empty. */
  optional?: boolean;
  enabled?: (state: Readonly<State>) => boolean;
  /** Of this page alone: acts with each move of the slider, and without a server. */
  local?: true;
  /** A slider over decades, or even steps. */
  slider?: "logarithmic" | "linear";
}

export function numberRow(store: Store, field: NumberField): HTMLElement {
  const { low, high } = field;
  const change = field.local ? field.change : throttle(100, field.change);
  const text = (value: number) => String(Number(value.toPrecision(3)));
  const input = h("input", {
    type: "number",
    step: "any",
    min: String(low),
    max: String(high),
    placeholder: field.optional ? "none" : "",
    onchange: () => {
      if (!input.reportValidity()) show();
      else if (input.value !== "") change(Number(input.value));
      else if (field.optional) change(null);
      else show();
    },
    attributes: { "aria-label": `${field.label}${field.unit ? ` in ${field.spoken ?? field.unit}` : ""}` },
  });
  const logarithmic = field.slider === "logarithmic";
  const from = Math.max(low, 1e-4 * high); // a slider over at most four decades
  const toSlider = (x: number) => (logarithmic ? Math.log(x / from) / Math.log(high / from) : (x - low) / (high - low));
  const fromSlider = (t: number) => (logarithmic ? from * (high / from) ** t : low + t * (high - low));
  const slider = h("input", {
    type: "range",
    min: "0",
    max: "1",
    step: logarithmic ? "0.005" : "0.01", // values have two digits
    oninput: () => {
      const value = Number(fromSlider(Number(slider.value)).toPrecision(2));
      input.value = text(value);
      change(value);
    },
    attributes: { "aria-label": `${field.label}, slider` },
  });
  const reset = resetButton(field.label, () => {
    const value = field.scene(store.get());
    if (value !== undefined) field.change(value);
  });
  const show = () => {
    const state = store.get();
    const value = field.now(state);
    input.value = typeof value === "number" ? text(value) : "";
    if (typeof value === "number") slider.value = String(toSlider(value));
    reset.hidden = same(value, field.scene(state));
  };
  follow(store, (s) => `${field.now(s)} ${field.scene(s)}`, show);
  const enabled = field.local ? () => true : (field.enabled ?? isOpen);
  store.watch(enabled, (on) => [input, slider, reset].forEach((element) => (element.disabled = !on)));
  return h(
    "div",
    { className: "value", title: field.title ?? "" },
    h("span", { className: "name" }, field.label, reset),
    h(
      "div",
      { className: "row" },
      field.slider ? slider : null,
      h("span", { className: "field" }, input, field.unit ? h("span", { className: "suffix" }, field.unit) : null),
    ),
  );
}

export const resetButton = (label: string, onclick: () => void): HTMLButtonElement =>
  h(
    "button",
    { type: "button", className: "link", onclick, attributes: { "aria-label": `Reset ${label.toLowerCase()}` } },
    "reset",
  );

const same = (a: number | null | undefined, b: number | null | undefined): boolean =>
  a === b ||
  (typeof a === "number" && typeof b === "number" && Math.abs(a - b) <= 1e-6 * Math.abs(b)) ||
  a === undefined;

/** A group of the panel that can be folded. */
export function group(title: string, open: boolean, ...children: (Node | null)[]): HTMLDetailsElement {
  return h("details", { open }, h("summary", {}, title), ...children);
}

/** One of a few: radio buttons in a row. */
export function segments<T extends string | number>(
  store: Store,
  label: string,
  choices: readonly { value: T; label: string }[],
  now: (state: Readonly<State>) => T | undefined,
  change: (value: T) => void,
): { element: HTMLElement; inputs: HTMLInputElement[] } {
  const inputs = choices.map(({ value }) =>
    h("input", { type: "radio", name: label, value: String(value), onchange: () => change(value) }),
  );
  const show = () => inputs.forEach((input, i) => (input.checked = choices[i].value === now(store.get())));
  follow(store, now, show);
  const element = h(
    "div",
    { className: "segments", attributes: { role: "radiogroup", "aria-label": label } },
    ...inputs.map((input, i) => h("label", {}, input, h("span", {}, choices[i].label))),
  );
  return { element, inputs };
}

export function toggle(
  store: Store,
  label: string,
  now: (state: Readonly<State>) => boolean,
  change: (on: boolean) => void,
): HTMLElement {
  const input = h("input", {
    type: "checkbox",
    onchange: () => change(input.checked),
    attributes: { role: "switch" },
  });
  store.watch(now, (on) => (input.checked = on));
  return h("label", { className: "row" }, label, input);
}

/** Takes a tool into the hand, or puts it down. */
export function toolButton(store: Store, tool: Tool, label: string, title: string): HTMLButtonElement {
  const toggle = () => store.set({ tool: store.get().tool === tool ? null : tool });
  const button = h("button", { type: "button", className: "tool", title, onclick: toggle }, label);
  store.watch(
    (s) => toolOf(s) === tool,
    (taken) => button.setAttribute("aria-pressed", String(taken)),
  );
  store.watch(isOpen, (open) => (button.disabled = !open));
  return button;
}
