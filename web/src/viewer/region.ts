// The rim of a region on the surface: where the surface leaves a ball. It is found once and then goes along with the
// object: each end of its segments lies at a fixed place of an edge of the surface.
//
//     const rim = findRim(positions, triangles, point, 0.02);
//     placeRim(rim, positions, ends);                      // [n][2][3], whenever positions have changed

import type { Vec3 } from "../messages";

export interface Rim {
  edges: Uint32Array; // [n][2][2] vertices: of each segment two ends, of each the edge that it lies on
  at: Float32Array; // [n][2] where on that edge, 0..1
}

/** positions [S][3], triangles [F][3]. Empty when all of the surface is inside or outside. */
export function findRim(positions: Float32Array, triangles: Uint32Array, [x, y, z]: Vec3, radius: number): Rim {
  const beyond = new Float32Array(positions.length / 3); // [m] of each vertex; <= 0: inside
  for (let v = 0, i = 0; v < beyond.length; ++v, i += 3)
    beyond[v] = Math.hypot(positions[i] - x, positions[i + 1] - y, positions[i + 2] - z) - radius;
  const edges: number[] = [];
  const at: number[] = [];
  for (let t = 0; t < triangles.length; t += 3)
    for (let corner = 0; corner < 3; ++corner) {
      // The corner that is alone on its side: both edges from it leave the ball.
      const a = triangles[t + corner];
      const b = triangles[t + ((corner + 1) % 3)];
      const c = triangles[t + ((corner + 2) % 3)];
      const inside = beyond[a] <= 0;
      if (beyond[b] <= 0 === inside || beyond[c] <= 0 === inside) continue;
      edges.push(a, b, a, c);
      at.push(beyond[a] / (beyond[a] - beyond[b]), beyond[a] / (beyond[a] - beyond[c]));
    }
  return { edges: Uint32Array.from(edges), at: Float32Array.from(at) };
}

/** Writes the ends of the segments from `offset` on, and returns where the next ones go. */
export function placeRim({ edges, at }: Rim, positions: Float32Array, ends: Float32Array, offset = 0): number {
  for (let i = 0; i < at.length; ++i) {
    const a = 3 * edges[2 * i];
    const b = 3 * edges[2 * i + 1];
    for (let axis = 0; axis < 3; ++axis)
      ends[offset++] = positions[a + axis] + at[i] * (positions[b + axis] - positions[a + axis]);
  }
  return offset;
}
