// Colours that carry meaning. The renderer of the PNGs uses the same ones: tests/golden/palette.json holds both sides to it.
// All values are sRGB, 0..1.

export type Rgb = readonly [number, number, number];

/** Level of refinement, 0 = coarsest. Levels beyond the last colour repeat it. */
const LEVELS: readonly string[] = ["#5b3bb3", "#2382cb", "#10b9b5", "#72d97c", "#d3e048", "#fde77c", "#fff6d0"];

/** Young's modulus, soft to stiff: perceptually uniform, light to dark. */
const STIFFNESS: readonly string[] = [
  ...["#f9ea92", "#fadd6d", "#fbc952", "#f8ad32", "#f18a19"],
  ...["#e66003", "#cc361e", "#a51e21", "#75151e"],
];

/** A pull's rubber band. */
export const PULL = "#c2186b";

type Range = readonly [number, number]; // [Pa]

const rgb = (hex: string): Rgb => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255) as unknown as Rgb;
const levels = LEVELS.map(rgb);
const stiffness = STIFFNESS.map(rgb);

export const levelColour = (level: number): Rgb => levels[Math.min(level, levels.length - 1)];

/** Piecewise linear between the map's stops; t is clamped to 0..1. */
export function mapColour(t: number): Rgb {
  const at = Math.min(1, Math.max(0, t)) * (stiffness.length - 1);
  const i = Math.min(stiffness.length - 2, Math.floor(at));
  const [a, b] = [stiffness[i], stiffness[i + 1]];
  const f = at - i;
  return [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])];
}

/** Over more than a decade, moduli are told apart on a logarithmic scale only. */
export const isLogarithmic = ([low, high]: Range): boolean => low > 0 && high > 10 * low;

/** Where a modulus lies in the legend's range, 0..1; the middle when the range has no width. */
export function stiffnessPosition(young: number, range: Range): number {
  const [low, high] = range;
  if (!(high > low)) return 0.5;
  const t = isLogarithmic(range) ? Math.log(young / low) / Math.log(high / low) : (young - low) / (high - low);
  return Math.min(1, Math.max(0, t));
}

/** The modulus at a position of the legend: the inverse. */
export function stiffnessAt(t: number, range: Range): number {
  const [low, high] = range;
  return isLogarithmic(range) ? low * (high / low) ** t : low + t * (high - low);
}

export const css = ([r, g, b]: Rgb): string =>
  `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`;
