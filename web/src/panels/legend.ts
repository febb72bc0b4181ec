// What the colours mean: levels as swatches with their number of tets, everything else as a bar with numbers and units.

import { count, quantityOfLength } from "../format";
import type { Hello } from "../messages";
import { css, levelColour, mapColour, MAPS } from "../palette";
import { isField } from "../scale";
import type { Scale } from "../scale";
import { scaleOf } from "../store";
import type { State, Store } from "../store";
import { h } from "./dom";

export function legend(store: Store, gridSpacing: () => number): HTMLElement {
  const element = h("section", { className: "card legend", attributes: { "aria-label": "Legend" } });
  const show = () => {
    const state = store.get();
    const { hello } = state;
    element.hidden = hello === null;
    if (!hello) return;
    const scale = scaleOf(state);
    const missing = scale === null && state.shape === "surface" && isField(state.colouring);
    element.replaceChildren(
      ...(scale ? bar(scale) : levels(hello)),
      ...(missing
        ? [h("p", { className: "scale" }, state.scrub === null ? "Waiting for values …" : "Kept without values")]
        : []),
      h("p", { className: "scale" }, `Grid ${quantityOfLength(gridSpacing())}`),
    );
    showCounts(state);
  };
  const showCounts = ({ simulation }: Readonly<State>) =>
    element.querySelectorAll("[data-level]").forEach((cell) => {
      const tets = simulation?.tets_by_level[Number((cell as HTMLElement).dataset["level"])];
      cell.textContent = tets === undefined ? "" : count(tets);
    });
  for (const part of ["hello", "colouring", "fieldRange", "shape", "scrub"] as const) store.watch((s) => s[part], show);
  store.watch(
    (s) => s.simulation?.tets_by_level.join(),
    () => showCounts(store.get()),
  );
  return element;
}

function levels({ depth }: Hello): HTMLElement[] {
  const rows = Array.from({ length: depth + 1 }, (_, level) => {
    const name = depth === 0 ? "only level" : level === 0 ? "coarsest" : level === depth ? "finest" : "";
    return h(
      "li",
      {},
      swatch(css(levelColour(level))),
      `${level}`,
      h("small", {}, name),
      h("b", { attributes: { "data-level": String(level) } }),
    );
  });
  return [h("h2", {}, "Level of refinement"), h("ul", {}, ...rows)];
}

function bar(scale: Scale): HTMLElement[] {
  const [low, high] = scale.range;
  const title = h("h2", {}, scale.title);
  if (!(high > low))
    return [title, h("ul", {}, h("li", {}, swatch(css(mapColour(0.5, scale.map))), `${scale.label(low)} everywhere`))];
  const map = h("div", { className: "map" });
  map.style.background = `linear-gradient(to right, ${MAPS[scale.map].map(css).join(", ")})`;
  const ticks = [0, 0.5, 1].map((t) => h("span", {}, scale.label(scale.valueAt(t))));
  const [left, right] = scale.ends ?? ["", ""];
  const words = [left, scale.logarithmic ? "log scale" : "", right];
  return [
    title,
    map,
    h("div", { className: "ticks" }, ...ticks),
    ...(words.some(Boolean) ? [h("p", { className: "ends" }, ...words.map((word) => h("span", {}, word)))] : []),
  ];
}

function swatch(colour: string): HTMLElement {
  const element = h("span", { className: "swatch" });
  element.style.background = colour;
  return element;
}
