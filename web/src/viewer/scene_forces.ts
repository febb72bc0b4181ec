// Forces that the scene itself has, beside those that viewers put there. The server says ten times a second where they act; in
// between they go along with the vertex of the surface that is nearest.

import type { SceneForce, Vec3 } from "../messages";

export class SceneForces {
  private acting: { vertex: number; offset: Vec3; value: Vec3 }[] = [];

  /** positions: of the surface at about the same moment, [S][3]. */
  set(forces: readonly SceneForce[], positions: Float32Array): void {
    this.acting = forces.map(({ at, value }) => {
      const vertex = nearest(positions, at);
      const offset = at.map((x, i) => x - positions[3 * vertex + i]) as unknown as Vec3;
      return { vertex, offset, value };
    });
  }

  /** Where they act on the surface as it is now. */
  at(positions: Float32Array): { at: Vec3; value: Vec3 }[] {
    return this.acting
      .filter(({ vertex }) => 3 * vertex < positions.length)
      .map(({ vertex, offset, value }) => ({
        at: offset.map((x, i) => x + positions[3 * vertex + i]) as unknown as Vec3,
        value,
      }));
  }
}

function nearest(positions: Float32Array, [x, y, z]: Vec3): number {
  let best = 0;
  let least = Infinity;
  for (let i = 0; i < positions.length; i += 3) {
    const squared = (positions[i] - x) ** 2 + (positions[i + 1] - y) ** 2 + (positions[i + 2] - z) ** 2;
    if (squared < least) [best, least] = [i / 3, squared];
  }
  return best;
}
