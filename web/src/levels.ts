// The levels of tets as settings have them. Of the deepest that the tree and the order have one says so, not its number: so it stays
// the deepest with another order, and in a link. Where the scene itself stops earlier, a number is meant as it is.

import type { Hello, Levels, Settings } from "./messages";

const ANY_DEPTH = 99;

type Tree = Pick<Hello, "depth" | "levels">;
type Chosen = Pick<Settings, "order" | "levels">;

/** 0: there is nothing to choose. */
export const deepestLevel = ({ depth }: Tree, order: number): number => Math.max(0, order === 2 ? depth - 1 : depth);

/** The scene's own, whatever the order. */
export const sceneLevels = ({ depth, levels }: Tree): Levels => levels ?? { min: 0, max: depth };

/** For a command that means the levels which these settings have. */
export function wantedLevels(tree: Tree, { order, levels }: Chosen): Levels | undefined {
  const deepest = levels && levels.max >= deepestLevel(tree, order) && sceneLevels(tree).max === tree.depth;
  return levels && { ...levels, max: deepest ? ANY_DEPTH : levels.max };
}

/** Whether nobody has chosen them: they are the scene's, as far as the order lets them be. */
export function areScenes(tree: Tree, { order, levels }: Chosen): boolean {
  const scene = sceneLevels(tree);
  const within = (level: number) => Math.min(level, deepestLevel(tree, order));
  return !levels || (levels.min === within(scene.min) && levels.max === within(scene.max));
}
