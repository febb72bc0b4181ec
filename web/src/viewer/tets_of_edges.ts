// The front's tets from its edges: the wire and recordings carry edges only, which is what a wireframe needs and a
// third of the bytes.
//
// Four vertices that are joined by six edges of one level are a tet of that level: an edge of level k is half as long as
// its parent, so an edge belongs to tets of a single level, and the octahedron inside of a refined tet is cut by one
// diagonal, so that no other four of its vertices are all joined. The edges of quadratic tets come in two halves; the
// vertex between them is the end of these two of that level alone, while a corner of a tet has three at least.
//
// One case is ambiguous: five vertices that are all joined. They are three tets around an edge, or four around a vertex; the
// other fours overlap these. Of five points in space, either one lies in the tet of the others or an edge pierces a triangle
// (Radon); what is real has that vertex, or that edge.
//
// What edges cannot tell: whether a notch of the mesh's boundary whose four corners are all joined is filled. It is drawn
// filled: 16 tets too many beside the bunny's 1,163.

export interface Tets {
  corners: Uint32Array; // [T][4]
  levels: Uint8Array; // [T]
}

export type Position = (vertex: number) => readonly [number, number, number];

/** edges [E][2] below `vertices`, levels [E]; positions without inverted tets, asked for in ambiguous cases only. Cost: the edges, and what their ends are joined to. */
export function tetsOfEdges(edges: Uint32Array, levels: Uint8Array, vertices: number, position: Position): Tets {
  const corners: number[] = [];
  const level: number[] = [];
  const top = levels.reduce((most, l) => Math.max(most, l), -1);
  for (let l = 0; l <= top; ++l) {
    const before = corners.length;
    appendCliques(upward(wholeEdges(edges, levels, vertices, l), vertices), vertices, position, corners);
    for (let i = before; i < corners.length; i += 4) level.push(l);
  }
  return { corners: Uint32Array.from(corners), levels: Uint8Array.from(level) };
}

/** Both ends of each edge of this level; two halves become one edge. */
function wholeEdges(edges: Uint32Array, levels: Uint8Array, vertices: number, level: number): number[] {
  const degree = new Uint32Array(vertices);
  for (let e = 0; e < levels.length; ++e)
    if (levels[e] === level) {
      ++degree[edges[2 * e]];
      ++degree[edges[2 * e + 1]];
    }
  const other = new Int32Array(vertices).fill(-1); // the first end that was met of a midpoint's two
  const whole: number[] = [];
  for (let e = 0; e < levels.length; ++e) {
    if (levels[e] !== level) continue;
    const [a, b] = [edges[2 * e], edges[2 * e + 1]];
    const middle = degree[a] === 2 ? a : degree[b] === 2 ? b : -1;
    if (middle < 0) whole.push(a, b);
    else if (other[middle] < 0) other[middle] = middle === a ? b : a;
    else whole.push(other[middle], middle === a ? b : a);
  }
  return whole;
}

interface Upward {
  start: Uint32Array; // [vertices + 1]
  to: Uint32Array;
}

/** For each vertex the larger ends of its edges: to[start[v]] .. to[start[v + 1]]. */
function upward(ends: number[], vertices: number): Upward {
  const start = new Uint32Array(vertices + 1);
  for (let i = 0; i < ends.length; i += 2) ++start[Math.min(ends[i], ends[i + 1]) + 1];
  for (let v = 0; v < vertices; ++v) start[v + 1] += start[v];
  const next = start.slice();
  const to = new Uint32Array(start[vertices]);
  for (let i = 0; i < ends.length; i += 2) to[next[Math.min(ends[i], ends[i + 1])]++] = Math.max(ends[i], ends[i + 1]);
  return { start, to };
}

/** a < b < c < d that are all joined, but for those that overlap others. */
function appendCliques({ start, to }: Upward, vertices: number, position: Position, out: number[]): void {
  const fours: number[][] = [];
  const false4 = new Set<string>();
  const ofA = new Int32Array(vertices).fill(-1); // ofA[v] === a: v is joined to a
  const ofB = new Int32Array(vertices).fill(-1); // ofB[v] === i: v is joined to b, the vertex to[i]
  for (let a = 0; a < vertices; ++a) {
    if (start[a + 1] - start[a] < 3) continue;
    for (let i = start[a]; i < start[a + 1]; ++i) ofA[to[i]] = a;
    for (let i = start[a]; i < start[a + 1]; ++i) {
      const b = to[i];
      for (let j = start[b]; j < start[b + 1]; ++j) ofB[to[j]] = i;
      for (let j = start[b]; j < start[b + 1]; ++j) {
        const c = to[j];
        if (ofA[c] !== a) continue;
        for (let k = start[c]; k < start[c + 1]; ++k) {
          const d = to[k];
          if (ofA[d] !== a || ofB[d] !== i) continue;
          fours.push([a, b, c, d]);
          for (let m = start[d]; m < start[d + 1]; ++m) {
            const e = to[m];
            if (ofA[e] === a && ofB[e] === i && to.subarray(start[c], start[c + 1]).includes(e))
              for (const four of overlapping([a, b, c, d, e], position)) false4.add(four.join());
          }
        }
      }
    }
  }
  for (const four of fours) if (false4.size === 0 || !false4.has(four.join())) out.push(...four);
}

/** Of five joined vertices, the fours without the vertex, or the edge, that is in the middle of the others. */
function overlapping(five: number[], position: Position): number[][] {
  const points = five.map(position);
  // Weights of the one affine dependency of five points: each is the signed volume of the other four.
  const weights = five.map((_, i) => (i % 2 ? -1 : 1) * volume(points.filter((_, j) => j !== i)));
  const positive = five.filter((_, i) => weights[i] > 0);
  const inner = positive.length <= 2 ? positive : five.filter((_, i) => weights[i] <= 0);
  return five.map((left) => five.filter((v) => v !== left)).filter((four) => !inner.every((v) => four.includes(v)));
}

function volume([a, b, c, d]: (readonly [number, number, number])[]): number {
  const [u, v, w] = [b, c, d].map((p) => [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
  return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) + u[2] * (v[0] * w[1] - v[1] * w[0]);
}
