import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";

import { FORCE, levelColour, mapColour, PULL } from "../../web/src/palette";
import type { Rgb } from "../../web/src/palette";
import { makeScale } from "../../web/src/scale";

// The renderer of the PNGs is held to the same file.
const golden = JSON.parse(readFileSync(new URL("../golden/palette.json", import.meta.url), "utf8")) as {
  levels: string[];
  stiffness: string[];
  field: string[];
  error: string[];
  pull: string;
  force: string;
  samples: { young: number; range: [number, number]; position: number; colour: number[] }[];
};
const bytes = (colour: Rgb) => colour.map((x) => Math.round(255 * x));
const hex = (colour: Rgb) =>
  `#${bytes(colour)
    .map((x) => x.toString(16).padStart(2, "0"))
    .join("")}`;

describe("the palette", () => {
  it("has the levels' colours, and repeats the last", () => {
    golden.levels.forEach((colour, level) => expect(hex(levelColour(level))).toBe(colour));
    expect(hex(levelColour(99))).toBe(golden.levels.at(-1));
  });

  it.each(["stiffness", "field", "error"] as const)("has the stops of the map %s and nothing in between", (map) => {
    const last = golden[map].length - 1;
    golden[map].forEach((colour, i) => expect(hex(mapColour(i / last, map))).toBe(colour));
    const [a, middle, b] = [0, 0.5 / last, 1 / last].map((t) => mapColour(t, map));
    middle.forEach((x, i) => expect(x).toBeCloseTo((a[i] + b[i]) / 2, 6));
  });

  it("has the colours of pulls and forces", () => expect([PULL, FORCE]).toEqual([golden.pull, golden.force]));

  it.each(golden.samples)("colours $young Pa within $range", ({ young, range, position, colour }) => {
    const scale = makeScale("stiffness", range);
    expect(scale.position(young)).toBeCloseTo(position, 5);
    bytes(mapColour(scale.position(young), "stiffness")).forEach((x, i) =>
      expect(Math.abs(x - colour[i])).toBeLessThanOrEqual(1),
    );
  });

  it.each([
    [1e4, 1e6],
    [1e5, 9e5],
  ] as const)("labels the legend by the inverse, %d to %d Pa", (low, high) => {
    const scale = makeScale("stiffness", [low, high]);
    for (const t of [0, 0.3, 0.5, 1]) expect(scale.position(scale.valueAt(t))).toBeCloseTo(t, 9);
  });
});
