// Colours that carry meaning. The renderer of the PNGs uses the same ones: tests/golden/palette.json holds both sides to it.
// All values are sRGB, 0..1.

export type Rgb = readonly [number, number, number];

/** Level of refinement, 0 = coarsest. Levels beyond the last colour repeat it. */
const LEVELS: readonly string[] = ["#3b6fb6", "#2fa39b", "#e0b13c", "#d9642f", "#b0335f", "#6d3b8e", "#3d3d4f"];

/** Young's modulus on a logarithmic scale, soft to stiff: viridis, which is perceptually uniform and safe for the colour-blind. */
const STIFFNESS: readonly string[] = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725"];

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

/** Where a modulus lies in the legend's range, logarithmically, 0..1; the middle when the range has no width. */
export function stiffnessPosition(young: number, [low, high]: readonly [number, number]): number {
  return high > low ? Math.min(1, Math.max(0, Math.log(young / low) / Math.log(high / low))) : 0.5;
}

export const css = ([r, g, b]: Rgb): string =>
  `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`;
