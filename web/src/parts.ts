// Parts of the object that are stiffer or softer than the scene says: what a key, a tap or a typed number says to the server.
// Pure. The server keeps parts in the order in which they were named, and the last word on a place counts. To take one away is to
// make it as stiff as the scene has it, below all others: those at the list's beginning the server forgets.
//
//     setPart(settings.stiffness_parts, part, 5).forEach(send)      // this one five times as stiff, all others as they were

import type { Command, Hello, StiffnessPart, SurfacePlace, Vec3 } from "./messages";

/** What a press of a key goes through; any factor from the first to the last can be typed. */
export const FACTORS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100] as const;

export type Place = SurfacePlace & Pick<StiffnessPart, "radius">;

/** The next factor up or down; at the ends the same. */
export const stepped = (factor: number, direction: 1 | -1): number =>
  direction > 0
    ? (FACTORS.find((f) => f > 1.001 * factor) ?? FACTORS[FACTORS.length - 1])
    : (FACTORS.findLast((f) => f < 0.999 * factor) ?? FACTORS[0]);

/** Those that change something, in the server's order. */
export const effective = (parts: readonly StiffnessPart[]): StiffnessPart[] => parts.filter(({ value }) => value !== 1);

export const isSame = (a: Place, b: Place): boolean =>
  a.triangle === b.triangle && a.radius === b.radius && a.barycentric.every((x, i) => x === b.barycentric[i]);

/** Names a part for as long as it is there, whatever its factor. */
export const keyOf = ({ triangle, barycentric, radius }: Place): string =>
  `${triangle} ${barycentric.join()} ${radius}`;

/** What a hand of this radius [m] means at a place: the part that it has made there before, or a new one as stiff as the place is
 * now. `away`: how far a part's middle is from the place [m]. */
export function partAt(
  parts: readonly StiffnessPart[],
  place: SurfacePlace,
  radius: number,
  away: (part: StiffnessPart) => number,
): StiffnessPart {
  const mine = parts.filter((part) => Math.abs(part.radius - radius) <= 1e-3 * radius && away(part) <= 0.5 * radius);
  const made = effective(mine).at(-1);
  if (made) return made;
  const { triangle, barycentric, radius: same } = mine.at(-1) ?? { ...place, radius }; // one without effect is used again
  const value = effective(parts).findLast((part) => away(part) <= part.radius)?.value ?? 1;
  return { value, triangle, barycentric, radius: same };
}

/** How stiff a place would be without this part. */
export const without = (parts: readonly StiffnessPart[], part: Place, away: (part: StiffnessPart) => number): number =>
  effective(parts).findLast((other) => !isSame(other, part) && away(other) <= other.radius)?.value ?? 1;

/** What a press of a key there says; `below`: how stiff the place is without the part. */
export function stepPart(
  parts: readonly StiffnessPart[],
  part: StiffnessPart,
  below: number,
  direction: 1 | -1,
): Command[] {
  const next = stepped(part.value, direction);
  // To take it away would make the place as stiff as what lies below it: a jump, or the wrong way.
  return setPart(parts, part, next === 1 && below !== 1 ? stepped(next, direction) : next);
}

/** Gives a part this factor and leaves the others as they are: those that lie over it are said again. */
export function setPart(parts: readonly StiffnessPart[], part: Place, value: number): Command[] {
  const others = effective(parts);
  const at = others.findIndex((other) => isSame(other, part));
  const over = others.filter((other, i) => !isSame(other, part) && (value === 1 || (at >= 0 && i > at)));
  return [{ ...part, value }, ...over].map(command);
}

/** What the server will say of its parts when it has done these. */
export function foresee(parts: readonly StiffnessPart[], commands: readonly Command[]): StiffnessPart[] {
  let now = [...parts];
  for (const command of commands)
    if (command.command === "stiffness_scale" && "radius" in command) {
      const { value, triangle, barycentric, radius } = command;
      const said = { value, triangle, barycentric, radius };
      now = [...now.filter((part) => !isSame(part, said)), said];
      while (now[0]?.value === 1) now.shift();
    }
  return now;
}

/** All as stiff as the scene says. */
export const clearParts = (parts: readonly StiffnessPart[]): Command[] =>
  effective(parts).map((part) => command({ ...part, value: 1 }));

/** To where a server that divides by the sum finds nothing to round: what it then says is the same place, to the bit. */
export function snapped([, v, w]: Vec3): Vec3 {
  const grid = (x: number) => Math.round(x * 2 ** 20) / 2 ** 20;
  const second = grid(v);
  const third = Math.min(grid(w), 1 - second);
  return [1 - second - third, second, third];
}

const command = ({ value, triangle, barycentric, radius }: StiffnessPart): Command => ({
  command: "stiffness_scale",
  value,
  triangle,
  barycentric,
  radius,
});

/** [m] around a point at rest that a hand pins or makes stiffer; `size`: in percent of the object's diagonal. */
export function regionRadius({ rest_box: box }: Pick<Hello, "rest_box">, size: number): number {
  return Math.max(1e-9, (size / 100) * Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]));
}
