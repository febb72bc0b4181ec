import { describe, expect, it } from "vitest";

import { findRim, placeRim } from "../../web/src/viewer/region";

/** A square sheet of n x n cells, two triangles each, from (0 0 0) to (1 1 0). */
function sheet(n: number) {
  const positions = new Float32Array(3 * (n + 1) ** 2);
  const triangles: number[] = [];
  for (let i = 0; i <= n; ++i)
    for (let j = 0; j <= n; ++j) {
      const v = i * (n + 1) + j;
      positions.set([i / n, j / n, 0], 3 * v);
      if (i < n && j < n) triangles.push(v, v + n + 1, v + 1, v + 1, v + n + 1, v + n + 2);
    }
  return { positions, triangles: Uint32Array.from(triangles) };
}

describe("a region's rim", () => {
  const { positions, triangles } = sheet(40);
  const rim = findRim(positions, triangles, [0.5, 0.5, 0], 0.3);
  const place = (of: Float32Array) => {
    const ends = new Float32Array(6 * rim.edges.length);
    const used = placeRim(rim, of, ends);
    return ends.subarray(0, used);
  };
  const length = (ends: Float32Array) => {
    let sum = 0;
    for (let i = 0; i < ends.length; i += 6) sum += Math.hypot(...[0, 1, 2].map((k) => ends[i + 3 + k] - ends[i + k]));
    return sum;
  };

  it("lies at its radius and is a whole circle", () => {
    const ends = place(positions);
    for (let i = 0; i < ends.length; i += 3)
      expect(Math.abs(Math.hypot(ends[i] - 0.5, ends[i + 1] - 0.5) - 0.3)).toBeLessThan(1e-3);
    expect(length(ends) / (2 * Math.PI * 0.3)).toBeCloseTo(1, 2);
  });

  it("goes along with the object", () => {
    const moved = positions.map((x, i) => (i % 3 === 2 ? 5 : 2 * x));
    const ends = place(moved);
    expect(length(ends) / (2 * Math.PI * 0.6)).toBeCloseTo(1, 2);
    for (let i = 2; i < ends.length; i += 3) expect(ends[i]).toBe(5);
  });

  it("is empty when all of the surface, or nothing, is inside", () => {
    for (const radius of [0, 1e-6, 2]) expect(findRim(positions, triangles, [0.51, 0.5, 0], radius).at.length).toBe(0);
  });

  it("is written one after the other", () => {
    const ends = new Float32Array(100_000);
    const next = placeRim(rim, positions, ends);
    expect(placeRim(rim, positions, ends, next)).toBe(2 * next);
    expect(ends.subarray(next, 2 * next)).toEqual(ends.subarray(0, next));
  });
});
