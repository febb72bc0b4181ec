// How numbers at the surface become colours, and what the legend says about them. Everything but levels, which are counts.
// The same rules as server/render/colour_scale.hpp, so that a snapshot has the same colours.
//
//     const scale = makeScale("stress", [0, 2.5e5]);
//     scale.position(1e5)                                   // 0.4
//     scale.title, scale.label(2.5e5)                       // "Von Mises stress", "250 kPa"

import { percent, quantity, quantityOfLength } from "./format";
import type { Colouring, FieldColouring } from "./messages";
import type { FrameValues } from "./protocol";
import type { MapName } from "./palette";

export type Range = readonly [number, number]; // low <= high

export interface Scale {
  title: string;
  map: MapName;
  range: Range;
  logarithmic: boolean;
  ends: readonly [string, string] | null; // words for both ends
  label: (value: number) => string;
  /** Where a value lies between the ends, 0..1; the middle when there is nothing between them. */
  position: (value: number) => number;
  valueAt: (position: number) => number;
}

type Kind = Pick<Scale, "title" | "map" | "label" | "ends">;
const KINDS: Record<Exclude<Colouring, "level">, Kind> = {
  stiffness: {
    title: "Young’s modulus",
    map: "stiffness",
    ends: ["soft", "stiff"],
    label: (value) => quantity(value, "Pa"),
  },
  displacement: { title: "Displacement", map: "field", ends: null, label: quantityOfLength },
  strain: { title: "Equivalent strain", map: "field", ends: null, label: percent },
  stress: { title: "Von Mises stress", map: "field", ends: null, label: (value) => quantity(value, "Pa") },
  error: { title: "Part of the error estimate", map: "error", ends: null, label: percent },
};

/** Names for the panel and the key C, in its order. */
export const COLOURINGS: readonly { value: Colouring; label: string }[] = [
  { value: "level", label: "Level" },
  { value: "stiffness", label: "Stiffness" },
  { value: "displacement", label: "Displacement" },
  { value: "strain", label: "Strain" },
  { value: "stress", label: "Stress" },
  { value: "error", label: "Error" },
];

export const isField = (colouring: Colouring): colouring is FieldColouring =>
  colouring !== "level" && colouring !== "stiffness";

export function makeScale(colouring: Exclude<Colouring, "level">, range: Range): Scale {
  const [low, high] = range;
  // Over more than a decade, moduli are told apart on a logarithmic scale only.
  const logarithmic = colouring === "stiffness" && low > 0 && high > 10 * low;
  const raw = (value: number) =>
    logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return {
    ...KINDS[colouring],
    range,
    logarithmic,
    position: (value) => (high > low ? Math.min(1, Math.max(0, raw(value))) : 0.5),
    valueAt: (t) => (logarithmic ? low * (high / low) ** t : low + t * (high - low)),
  };
}

/** The smallest of 1, 1.5, 2, 3, 4, 5, 6 and 8 times a power of ten that is not below x; 0 for x <= 0. */
export function readableCeiling(x: number): number {
  if (!(x > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(x));
  const step = [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((s) => s * power >= x * (1 - 1e-9));
  return Number(((step ?? 10) * power).toPrecision(2));
}

/** Follows a field's typical value: up at once, down only after it has stayed well below, so that colours do not flicker. */
export class RangeFollower {
  private field: FieldColouring | null = null;
  private high = 0;
  private since = 0; // [ms] it has been below since

  /** Where the colours end at time `now` [ms]. */
  follow(values: Pick<FrameValues, "field" | "typical">, now: number): number {
    const wanted = readableCeiling(values.typical);
    if (values.field !== this.field || wanted > this.high || this.high === 0) {
      this.field = values.field;
      this.high = wanted;
      this.since = now;
    } else if (wanted >= 0.6 * this.high) {
      this.since = now;
    } else if (now - this.since > 1500) {
      this.high = wanted;
      this.since = now;
    }
    return this.high;
  }
}
