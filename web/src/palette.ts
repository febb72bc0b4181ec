// Colours that carry meaning. The renderer of the PNGs uses the same ones: tests/golden/palette.json holds both sides to it.
// All values are sRGB, 0..1.

export type Rgb = readonly [number, number, number];

const rgb = (hex: string): Rgb => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255) as unknown as Rgb;

/** Level of refinement, 0 = coarsest. Levels beyond the last colour repeat it. */
const LEVELS = ["#5b3bb3", "#2382cb", "#10b9b5", "#72d97c", "#d3e048", "#fde77c", "#fff6d0"].map(rgb);

/** Perceptually uniform maps, stops at equal distances. */
export const MAPS = {
  /** Young's modulus, soft to stiff. */
  stiffness: [
    ...["#f9ea92", "#fadd6d", "#fbc952", "#f8ad32", "#f18a19"],
    ...["#e66003", "#cc361e", "#a51e21", "#75151e"],
  ].map(rgb),
  /** Displacement, strain, stress: viridis. */
  field: [
    ...["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c"],
    ...["#28ae80", "#5ec962", "#addc30", "#fde725"],
  ].map(rgb),
  /** The error estimate: cividis. */
  error: [
    ...["#00224e", "#123570", "#3b496c", "#575d6d", "#707173"],
    ...["#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"],
  ].map(rgb),
} as const;
export type MapName = keyof typeof MAPS;

/** A pull's rubber band. */
export const PULL = "#c2186b";
/** The arrow of a force that stays. */
export const FORCE = "#d97706";

export const levelColour = (level: number): Rgb => LEVELS[Math.min(level, LEVELS.length - 1)];

/** Piecewise linear between the map's stops; t is clamped to 0..1. */
export function mapColour(t: number, map: MapName): Rgb {
  const stops = MAPS[map];
  const at = Math.min(1, Math.max(0, t)) * (stops.length - 1);
  const i = Math.min(stops.length - 2, Math.floor(at));
  const [a, b] = [stops[i], stops[i + 1]];
  const f = at - i;
  return [a[0] + f * (b[0] - a[0]), a[1] + f * (b[1] - a[1]), a[2] + f * (b[2] - a[2])];
}

export const css = ([r, g, b]: Rgb): string =>
  `rgb(${Math.round(255 * r)} ${Math.round(255 * g)} ${Math.round(255 * b)})`;
