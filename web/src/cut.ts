// The page's cut, along an axis of the object's rest box, and the plane of a view as scenes and the server have it.

import type { CutPlane } from "./messages";
import type { Cut } from "./store";

export function planeOf({ axis, at, flip }: Cut, box: readonly number[]): CutPlane {
  const point = [0, 1, 2].map((i) => 0.5 * (box[i] + box[3 + i]));
  point[axis] = box[axis] + at * (box[3 + axis] - box[axis]);
  const normal = [0, 1, 2].map((i) => (i === axis ? (flip ? -1 : 1) : 0));
  return { point, normal };
}

/** Null for a plane that lies along no axis, or beside the box: the page has no such cut. */
export function cutOf(plane: CutPlane | undefined, box: readonly number[]): Cut | null {
  if (!plane) return null;
  const { point, normal } = plane;
  const length = Math.hypot(...normal);
  const axis = normal.findIndex((x) => Math.abs(x) > (1 - 1e-6) * length);
  if (axis !== 0 && axis !== 1 && axis !== 2) return null;
  const at = (point[axis] - box[axis]) / (box[3 + axis] - box[axis]);
  return at >= 0 && at <= 1 ? { axis, at, flip: normal[axis] < 0 } : null;
}
