import { describe, expect, it } from "vitest";

import { tetsOfEdges } from "../../web/src/viewer/tets_of_edges";
import { frontGrid } from "../browser/mock_shapes.mjs";

interface Front {
  edges: Uint32Array;
  levels: Uint8Array;
  vertices: Float64Array;
  tets: Uint32Array;
  tetLevels: Uint8Array;
}

const names = (corners: Uint32Array, levels: Uint8Array): string[] =>
  Array.from(
    levels,
    (level, t) => `${level}: ${[...corners.slice(4 * t, 4 * t + 4)].sort((a, b) => a - b).join()}`,
  ).sort();

/** The edges as those of quadratic tets: each in two halves, with new vertices between them. */
function halved({ edges, levels, vertices }: Front) {
  const count = vertices.length / 3;
  const halves = [...levels].flatMap((_, e) => [edges[2 * e], count + e, count + e, edges[2 * e + 1]]);
  return {
    edges: Uint32Array.from(halves),
    levels: Uint8Array.from([...levels].flatMap((l) => [l, l])),
    count: count + levels.length,
  };
}

const never = () => {
  throw new Error("nothing is ambiguous here");
};

describe("tetsOfEdges", () => {
  it.each([false, true])("finds the tets of a lattice, of two sizes: %s", (fine) => {
    const front = frontGrid(fine) as Front;
    const wanted = names(front.tets, front.tetLevels);
    expect(wanted.length).toBeGreaterThan(100);
    const found = tetsOfEdges(front.edges, front.levels, front.vertices.length / 3, never);
    expect(names(found.corners, found.levels)).toEqual(wanted);
    const quadratic = halved(front);
    const same = tetsOfEdges(quadratic.edges, quadratic.levels, quadratic.count, never);
    expect(names(same.corners, same.levels)).toEqual(wanted);
  });

  it("finds the eight children of a tet, not the octahedron's other fours", () => {
    // corners 0..3, midpoints of 01 02 03 12 13 23 are 4..9; the diagonal joins 4 and 9
    const children = [
      ...[0, 4, 5, 6, 1, 4, 7, 8, 2, 5, 7, 9, 3, 6, 8, 9],
      ...[4, 9, 5, 6, 4, 9, 6, 8, 4, 9, 8, 7, 4, 9, 7, 5],
    ];
    const edges = new Set<string>();
    for (let t = 0; t < children.length; t += 4)
      for (let i = 0; i < 4; ++i)
        for (let j = 0; j < i; ++j) edges.add([children[t + i], children[t + j]].sort((a, b) => a - b).join());
    const ends = Uint32Array.from([...edges].flatMap((edge) => edge.split(",").map(Number)));
    const found = tetsOfEdges(ends, new Uint8Array(edges.size).fill(1), 10, never);
    expect(names(found.corners, found.levels)).toEqual(names(Uint32Array.from(children), new Uint8Array(8).fill(1)));
  });

  const all5 = () => {
    const ends: number[] = [];
    for (let a = 0; a < 5; ++a) for (let b = 0; b < a; ++b) ends.push(b, a);
    return Uint32Array.from(ends);
  };
  const corners = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] as const; // prettier-ignore

  it.each([
    ["around a vertex", [0.2, 0.2, 0.2], ["0,1,2,4", "0,1,3,4", "0,2,3,4", "1,2,3,4"]],
    ["around an edge", [1, 1, 1], ["0,1,2,4", "0,1,3,4", "0,2,3,4"]],
  ] as const)("keeps the real ones of five joined vertices, %s", (_, last, wanted) => {
    const points = [...corners, last];
    const found = tetsOfEdges(all5(), new Uint8Array(10), 5, (v) => points[v]);
    expect(names(found.corners, found.levels)).toEqual(wanted.map((name) => `0: ${name}`));
  });

  it("finds nothing in nothing", () => {
    expect(tetsOfEdges(new Uint32Array(0), new Uint8Array(0), 0, never).levels.length).toBe(0);
  });
});
