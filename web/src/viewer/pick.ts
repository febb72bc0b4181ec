// Which triangle of the surface a ray hits first, and where in it (Moeller & Trumbore 1997), over the typed arrays that
// the viewer draws. Both sides count: one can grab the inside of an open surface.

import type { Vec3 } from "../messages";

export interface Hit {
  triangle: number;
  barycentric: Vec3; // sum 1
  point: Vec3; // [m]
  distance: number; // in lengths of the direction
}

/** positions [S][3], triangles [F][3]. Null when nothing is hit in front of the origin. */
export function pick(positions: Float32Array, triangles: Uint32Array, origin: Vec3, direction: Vec3): Hit | null {
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  let nearest = Infinity;
  let triangle = -1;
  let bestU = 0;
  let bestV = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t];
    const b = 3 * triangles[t + 1];
    const c = 3 * triangles[t + 2];
    const ax = positions[a];
    const ay = positions[a + 1];
    const az = positions[a + 2];
    const ex = positions[b] - ax;
    const ey = positions[b + 1] - ay;
    const ez = positions[b + 2] - az;
    const fx = positions[c] - ax;
    const fy = positions[c + 1] - ay;
    const fz = positions[c + 2] - az;
    const px = dy * fz - dz * fy;
    const py = dz * fx - dx * fz;
    const pz = dx * fy - dy * fx;
    const det = ex * px + ey * py + ez * pz;
    if (det === 0) continue;
    const sx = ox - ax;
    const sy = oy - ay;
    const sz = oz - az;
    const u = (sx * px + sy * py + sz * pz) / det;
    if (!(u >= 0 && u <= 1)) continue;
    const qx = sy * ez - sz * ey;
    const qy = sz * ex - sx * ez;
    const qz = sx * ey - sy * ex;
    const v = (dx * qx + dy * qy + dz * qz) / det;
    if (!(v >= 0 && u + v <= 1)) continue;
    const distance = (fx * qx + fy * qy + fz * qz) / det;
    if (!(distance > 0 && distance < nearest)) continue;
    nearest = distance;
    triangle = t / 3;
    bestU = u;
    bestV = v;
  }
  if (triangle < 0) return null;
  return {
    triangle,
    barycentric: [Math.max(0, 1 - bestU - bestV), bestU, bestV],
    point: [ox + nearest * dx, oy + nearest * dy, oz + nearest * dz],
    distance: nearest,
  };
}

/** The point with these barycentric coordinates now. */
export function surfacePoint(
  positions: Float32Array,
  triangles: Uint32Array,
  triangle: number,
  barycentric: Vec3,
): [number, number, number] {
  const point: [number, number, number] = [0, 0, 0];
  for (let corner = 0; corner < 3; ++corner) {
    const vertex = 3 * triangles[3 * triangle + corner];
    for (let axis = 0; axis < 3; ++axis) point[axis] += barycentric[corner] * positions[vertex + axis];
  }
  return point;
}
