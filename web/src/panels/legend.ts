// What the colours mean: levels as swatches, Young's modulus as a bar with its ends and middle.

import { quantity } from "../format";
import { css, isLogarithmic, levelColour, mapColour, stiffnessAt, stiffnessPosition } from "../palette";
import type { Hello } from "../protocol";
import type { Store } from "../store";
import { h } from "./dom";

export function legend(store: Store, gridSpacing: () => number): HTMLElement {
  const element = h("section", { className: "card legend", attributes: { "aria-label": "Legend" } });
  const show = () => {
    const { hello, colouring } = store.get();
    element.hidden = hello === null;
    if (!hello) return;
    element.replaceChildren(
      ...(colouring === "level" ? levels(hello) : stiffness(hello)),
      h("p", { className: "scale" }, `Grid ${quantityOfLength(gridSpacing())}`),
    );
  };
  store.watch((s) => s.hello, show);
  store.watch((s) => s.colouring, show);
  return element;
}

function levels({ depth }: Hello): HTMLElement[] {
  const rows = Array.from({ length: depth + 1 }, (_, level) => {
    const swatch = h("span", { className: "swatch" });
    swatch.style.background = css(levelColour(level));
    const name = depth === 0 ? "only level" : level === 0 ? "coarsest" : level === depth ? "finest" : "";
    return h("li", {}, swatch, `${level}`, h("small", {}, name));
  });
  return [h("h2", {}, "Level of refinement"), h("ul", {}, ...rows)];
}

function stiffness({ young_range: range }: Hello): HTMLElement[] {
  const [low, high] = range;
  const title = h("h2", {}, "Young’s modulus");
  if (!(high > low)) {
    const swatch = h("span", { className: "swatch" });
    swatch.style.background = css(mapColour(stiffnessPosition(low, range)));
    return [title, h("ul", {}, h("li", {}, swatch, `${quantity(low, "Pa")} everywhere`))];
  }
  const scale = isLogarithmic(range) ? "log scale" : "";
  const stops = Array.from({ length: 33 }, (_, i) => css(mapColour(i / 32)));
  const bar = h("div", { className: "map" });
  bar.style.background = `linear-gradient(to right, ${stops.join(", ")})`;
  const ticks = [0, 0.5, 1].map((t) => h("span", {}, quantity(stiffnessAt(t, range), "Pa")));
  return [
    title,
    bar,
    h("div", { className: "ticks" }, ...ticks),
    h("p", { className: "ends" }, h("span", {}, "soft"), h("span", {}, scale), h("span", {}, "stiff")),
  ];
}

/** 0.002 -> 2 mm, 0.05 -> 5 cm, 2 -> 2 m */
export function quantityOfLength(metres: number): string {
  if (metres < 0.0099) return quantity(1000 * metres, "mm");
  return metres < 0.99 ? quantity(100 * metres, "cm") : quantity(metres, "m");
}
