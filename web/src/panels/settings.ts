// What one can change: colouring, wireframe, tolerance, gravity. A change acts at once; a value that the server refuses
// goes back to the server's.

import type { Command, Vec3 } from "../protocol";
import { isOpen } from "../store";
import type { State, Store } from "../store";
import { h, throttle } from "./dom";

const TOLERANCE = { low: 1e-4, high: 1 }; // of the slider; any value the server allows can be typed

export function settings(store: Store, send: (command: Command) => void): HTMLElement {
  return h("div", { className: "settings" }, view(store), tolerance(store, send), gravity(store, send));
}

function view(store: Store): HTMLElement {
  const choice = (value: State["colouring"], label: string) => {
    const input = h("input", {
      type: "radio",
      name: "colouring",
      value,
      onchange: () => store.set({ colouring: value }),
    });
    store.watch(
      (s) => s.colouring,
      (now) => (input.checked = now === value),
    );
    return h("label", {}, input, h("span", {}, label));
  };
  const wireframe = h("input", {
    type: "checkbox",
    onchange: () => store.set({ wireframe: wireframe.checked }),
    attributes: { role: "switch" },
  });
  store.watch(
    (s) => s.wireframe,
    (on) => (wireframe.checked = on),
  );
  return h(
    "fieldset",
    {},
    h("legend", {}, "View"),
    h(
      "div",
      { className: "segments", attributes: { role: "radiogroup", "aria-label": "Colouring" } },
      choice("level", "Level"),
      choice("stiffness", "Stiffness"),
    ),
    h("label", { className: "row" }, "Wireframe of the front", wireframe),
  );
}

function tolerance(store: Store, send: (command: Command) => void): HTMLElement {
  const change = throttle(100, (value: number) => send({ command: "tolerance", value }));
  const span = Math.log(TOLERANCE.high / TOLERANCE.low);
  const slider = h("input", {
    type: "range",
    min: "0",
    max: "1",
    step: "0.005",
    oninput: () => {
      const value = Number((TOLERANCE.low * Math.exp(span * Number(slider.value))).toPrecision(2));
      number.value = text(value);
      change(value);
    },
    attributes: { "aria-label": "Tolerance, slider" },
  });
  const number = h("input", {
    type: "number",
    step: "any",
    min: "0.0001",
    max: "100",
    onchange: () => (number.reportValidity() && number.value !== "" ? change(Number(number.value) / 100) : show()),
    attributes: { "aria-label": "Tolerance in percent" },
  });
  const text = (value: number) => String(Number((100 * value).toPrecision(3)));
  const show = () => {
    const { simulation, hello } = store.get();
    const value = simulation?.tolerance ?? hello?.tolerance;
    if (value === undefined) return;
    number.value = text(value);
    slider.value = String(Math.log(value / TOLERANCE.low) / span);
  };
  store.watch((s) => s.simulation?.tolerance ?? s.hello?.tolerance, show);
  enableWhenOpen(store, slider, number);
  return h(
    "fieldset",
    { title: "The front is refined until the estimated error is below this; smaller is more accurate and slower" },
    h("legend", {}, "Tolerance"),
    resetButton(store, "Reset tolerance", () => {
      const value = store.get().hello?.tolerance;
      if (value !== undefined) change(value);
    }),
    h(
      "div",
      { className: "row" },
      slider,
      h("span", { className: "field percent" }, number, h("span", { className: "suffix" }, "%")),
    ),
  );
}

function gravity(store: Store, send: (command: Command) => void): HTMLElement {
  const change = (value: Vec3) => send({ command: "gravity", value });
  const inputs = ["x", "y", "z"].map((axis) =>
    h("input", {
      type: "number",
      step: "any",
      min: "-10000",
      max: "10000",
      onchange: () => {
        if (inputs.every((input) => input.value !== "" && input.reportValidity()))
          change(inputs.map((input) => Number(input.value)) as unknown as Vec3);
        else show();
      },
      attributes: { "aria-label": `Gravity along ${axis} in metres per second squared` },
    }),
  );
  const show = () => {
    const { simulation, hello } = store.get();
    const value = simulation?.gravity ?? hello?.gravity;
    if (value) inputs.forEach((input, i) => (input.value = String(Number(value[i].toPrecision(6)))));
  };
  store.watch((s) => (s.simulation?.gravity ?? s.hello?.gravity)?.join(), show);
  enableWhenOpen(store, ...inputs);
  return h(
    "fieldset",
    {},
    h("legend", {}, "Gravity ", h("small", {}, "m/s²")),
    resetButton(store, "Reset gravity", () => {
      const value = store.get().hello?.gravity;
      if (value) change(value);
    }),
    h(
      "div",
      { className: "row three" },
      ...inputs.map((input, i) =>
        h("label", { className: "field" }, h("span", { className: "axis" }, "xyz"[i]), input),
      ),
    ),
  );
}

function resetButton(store: Store, label: string, onclick: () => void): HTMLElement {
  const button = h(
    "button",
    { type: "button", className: "link", onclick, attributes: { "aria-label": label } },
    "reset",
  );
  enableWhenOpen(store, button);
  return button;
}

function enableWhenOpen(store: Store, ...elements: (HTMLInputElement | HTMLButtonElement)[]): void {
  store.watch(isOpen, (open) => elements.forEach((element) => (element.disabled = !open)));
}
