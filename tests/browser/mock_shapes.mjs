// The mock's geometry: a ball that stands on the ground, in a box of tetrahedra.

/** A subdivided octahedron of radius 0.5 around (0, 0, 0.5): detail 4 has 1,026 vertices, 5 has 4,098. */
export function ball(detail) {
  let points = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]; // prettier-ignore
  let faces = [[4, 0, 2], [4, 2, 1], [4, 1, 3], [4, 3, 0], [5, 2, 0], [5, 1, 2], [5, 3, 1], [5, 0, 3]]; // prettier-ignore
  for (let level = 0; level < detail; ++level) {
    const midpoints = new Map();
    const midpoint = (a, b) => {
      const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
      if (!midpoints.has(key)) {
        const sum = points[a].map((x, i) => x + points[b][i]);
        points.push(sum.map((x) => x / Math.hypot(...sum)));
        midpoints.set(key, points.length - 1);
      }
      return midpoints.get(key);
    };
    faces = faces.flatMap(([a, b, c]) => {
      const [ab, bc, ca] = [midpoint(a, b), midpoint(b, c), midpoint(c, a)];
      return [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]; // prettier-ignore
    });
  }
  const rest = Float64Array.from(points.flatMap(([x, y, z]) => [0.5 * x, 0.5 * y, 0.5 * z + 0.5]));
  return {
    rest, // [S][3]
    triangles: Uint32Array.from(faces.flat()),
    young: Float32Array.from(points, ([, , z]) => 1e7 * 0.01 ** ((z + 1) / 2)), // stiff at the ground
  };
}

/** Edges of a grid of cells, each cut into six tetrahedra. The cells at the ground have half the size, and those of x > 0
 * when it is `fine`. */
export function frontGrid(fine) {
  const vertices = [];
  const tets = [];
  const tetLevels = [];
  const known = new Map();
  const edges = new Map();
  const vertex = (p) => {
    const key = p.map((x) => x.toFixed(4)).join();
    if (!known.has(key)) {
      known.set(key, vertices.length / 3);
      vertices.push(...p);
    }
    return known.get(key);
  };
  const orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]]; // prettier-ignore
  const cell = (low, size, level) => {
    const middle = low.map((x, i) => x + size / 2 - (i === 2 ? 0.5 : 0));
    if (Math.hypot(...middle) > 0.5 + 0.6 * size) return;
    for (const order of orders) {
      const corner = [...low];
      const path = [vertex(corner)];
      for (const axis of order) {
        corner[axis] += size;
        path.push(vertex(corner));
      }
      tets.push(...path);
      tetLevels.push(level);
      for (let i = 0; i < 4; ++i)
        for (let j = i + 1; j < 4; ++j) edges.set(`${Math.min(path[i], path[j])} ${Math.max(path[i], path[j])}`, level);
    }
  };
  for (let x = -0.55; x < 0.5; x += 0.275)
    for (let y = -0.55; y < 0.5; y += 0.275)
      for (let z = -0.05; z < 1; z += 0.275) {
        if (z > 0.2 && (!fine || x < -0.01)) cell([x, y, z], 0.275, 0);
        else
          for (let k = 0; k < 8; ++k)
            cell([x + 0.1375 * (k & 1), y + 0.1375 * ((k >> 1) & 1), z + 0.1375 * (k >> 2)], 0.1375, 1);
      }
  return {
    vertices: Float64Array.from(vertices), // [N][3]
    edges: Uint32Array.from([...edges.keys()].flatMap((key) => key.split(" ").map(Number))),
    levels: Uint8Array.from(edges.values()),
    tets: Uint32Array.from(tets), // [T][4]
    tetLevels: Uint8Array.from(tetLevels),
  };
}
