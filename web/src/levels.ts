// The levels of tets as settings have them. Of the deepest that the tree and the order have one says so, not its number: so it stays
// the deepest with another order, and in a link.

import type { Hello, Levels, Settings } from "./messages";

const ANY_DEPTH = 99;

/** 0: there is nothing to choose. */
export const deepestLevel = ({ depth }: Pick<Hello, "depth">, order: number): number =>
  Math.max(0, order === 2 ? depth - 1 : depth);

/** For a command that means the levels which these settings have. */
export function wantedLevels(hello: Pick<Hello, "depth">, { order, levels }: Settings): Levels | undefined {
  return levels && { ...levels, max: levels.max >= deepestLevel(hello, order) ? ANY_DEPTH : levels.max };
}
