// What one sees of the object: its colours, surface or tets, the wireframe, the cut.

import { COLOURINGS } from "../scale";
import { colouringsOf } from "../store";
import type { Cut, Shape, Store } from "../store";
import { h } from "./dom";
import { group, numberRow, segments, toggle } from "./fields";

export function view(store: Store): HTMLElement {
  const colouring = segments(
    store,
    "Colouring",
    COLOURINGS,
    (s) => s.colouring,
    (value) => store.set({ colouring: value, shape: "surface" }),
  );
  store.watch(
    (s) => s.hello,
    (hello) =>
      colouring.inputs.forEach((input) => {
        const offered = colouringsOf(hello).some(({ value }) => value === input.value);
        (input.parentElement as HTMLElement).hidden = !offered;
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
  const row = numberRow(store, {
    label: "Explode",
    unit: "%",
    spoken: "percent",
    title: "How far the tetrahedra are apart",
    low: 0,
    high: 100,
    slider: "linear",
    now: (s) => 100 * s.explode,
    scene: () => 0,
    change: (value) => value !== null && store.set({ explode: value / 100, shape: "tets" }),
    local: true,
  });
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
  const flip = h(
    "button",
    { type: "button", onclick: () => change({ flip: !store.get().cut?.flip }), title: "Hide the other side" },
    "Flip",
  );
  const place = numberRow(store, {
    label: "Place of the cut",
    unit: "%",
    spoken: "percent",
    title: "How far the cut is through the object at rest",
    low: 0,
    high: 100,
    slider: "linear",
    now: (s) => s.cut && 100 * s.cut.at,
    scene: () => 50,
    change: (value) => value !== null && change({ at: value / 100 }),
    local: true,
  });
  const details = h("div", {}, h("div", { className: "row slide" }, axis.element, flip), place);
  store.watch(
    (s) => s.cut !== null,
    (visible) => (details.hidden = !visible),
  );
  return h("div", {}, on, details);
}
