// What one sees of the object: its colours, surface or tets, the wireframe, the cut.

import { colourings } from "../actions";
import { COLOURINGS, isField } from "../scale";
import { can } from "../store";
import type { Cut, Shape, Store } from "../store";
import { h } from "./dom";
import { group, segments, toggle } from "./fields";

export function view(store: Store): HTMLElement {
  const colouring = segments(
    store,
    "Colouring",
    COLOURINGS,
    (s) => s.colouring,
    (value) => store.set({ colouring: value, shape: "surface" }),
  );
  store.watch(
    (s) => can(s, "colouring"),
    () =>
      colouring.inputs.forEach((input) => {
        const offered = colourings(store.get()).some(({ value }) => value === input.value);
        (input.parentElement as HTMLElement).hidden = !offered && isField(input.value as never);
      }),
  );
  colouring.element.classList.add("many");
  const shape = segments<Shape>(
    store,
    "Shape",
    [
      { value: "surface", label: "Surface" },
      { value: "tets", label: "Tetrahedra" },
    ],
    (s) => s.shape,
    (value) => store.set({ shape: value }),
  );
  return group(
    "View",
    true,
    shape.element,
    colouring.element,
    toggle(
      store,
      "Wireframe of the front",
      (s) => s.wireframe,
      (wireframe) => store.set({ wireframe }),
    ),
    explode(store),
    cut(store),
  );
}

function explode(store: Store): HTMLElement {
  const slider = h("input", {
    type: "range",
    min: "0",
    max: "1",
    step: "0.01",
    oninput: () => store.set({ explode: Number(slider.value), shape: "tets" }),
    attributes: { "aria-label": "Explode" },
  });
  store.watch(
    (s) => s.explode,
    (value) => (slider.value = String(value)),
  );
  const row = h("label", { className: "row slide" }, h("span", {}, "Explode"), slider);
  store.watch(
    (s) => s.shape === "tets",
    (tets) => (row.hidden = !tets),
  );
  return row;
}

function cut(store: Store): HTMLElement {
  const change = (patch: Partial<Cut>) =>
    store.set({ cut: { ...(store.get().cut ?? { axis: 0, at: 0.5, flip: false }), ...patch } });
  const on = toggle(
    store,
    "Cut open",
    (s) => s.cut !== null,
    (wanted) => (wanted ? change({}) : store.set({ cut: null })),
  );
  const axis = segments(
    store,
    "Axis of the cut",
    [
      { value: 0, label: "x" },
      { value: 1, label: "y" },
      { value: 2, label: "z" },
    ],
    (s) => s.cut?.axis,
    (value) => change({ axis: value as Cut["axis"] }),
  );
  const slider = h("input", {
    type: "range",
    min: "0",
    max: "1",
    step: "0.005",
    oninput: () => change({ at: Number(slider.value) }),
    attributes: { "aria-label": "Place of the cut" },
  });
  store.watch(
    (s) => s.cut?.at,
    (at) => at !== undefined && (slider.value = String(at)),
  );
  const flip = h(
    "button",
    { type: "button", onclick: () => change({ flip: !store.get().cut?.flip }), title: "Hide the other side" },
    "Flip",
  );
  const details = h("div", { className: "row slide" }, axis.element, slider, flip);
  store.watch(
    (s) => s.cut !== null,
    (visible) => (details.hidden = !visible),
  );
  return h("div", {}, on, details);
}
