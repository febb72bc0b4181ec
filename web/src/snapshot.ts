// A picture to keep: drawn by the server with the page's camera, or what the canvas shows. The server's picture shows what
// the panels leave free of the page's, so both have the object at the same place.

import type { Vec3 } from "./messages";
import { shownColouring } from "./store";
import type { State } from "./store";
import type { Covered } from "./viewer/camera";

export interface Framing {
  eye: Vec3;
  target: Vec3;
  field_of_view: number; // [degrees] of the whole canvas, vertical
  width: number; // [CSS px] of the canvas
  height: number;
  covered: Covered;
}

/** The query of /snapshot.png. */
export function snapshotQuery(state: Readonly<State>, framing: Framing, transparent = false): string {
  const { eye, target, covered } = framing;
  const width = Math.round(framing.width - covered.left - covered.right);
  const height = Math.round(framing.height - covered.top - covered.bottom);
  const half = Math.tan((framing.field_of_view * Math.PI) / 360) * (height / framing.height);
  const view = {
    eye,
    target,
    field_of_view: Math.min(120, Math.max(5, (2 * Math.atan(half) * 180) / Math.PI)),
    colouring: shownColouring(state),
    wireframe: state.wireframe,
    background: transparent ? "transparent" : state.dark ? "dark" : "light",
    ...(state.cut && state.hello ? { cut: cutOf(state.cut, state.hello.rest_box) } : {}),
  };
  return new URLSearchParams({
    w: String(Math.min(4096, Math.max(16, width))),
    h: String(Math.min(4096, Math.max(16, height))),
    view: JSON.stringify(view),
  }).toString();
}

function cutOf({ axis, at, flip }: NonNullable<State["cut"]>, box: readonly number[]) {
  const point = [0, 1, 2].map((i) => 0.5 * (box[i] + box[3 + i]));
  point[axis] = box[axis] + at * (box[3 + axis] - box[axis]);
  return { point, normal: [0, 1, 2].map((i) => (i === axis ? (flip ? -1 : 1) : 0)) };
}

/** Throws an Error with one readable line. */
export async function fetchSnapshot(query: string): Promise<Blob> {
  const answer = await fetch(`snapshot.png?${query}`).catch(() => null);
  if (!answer) throw new Error("the server did not answer");
  if (!answer.ok) throw new Error((await answer.text()).trim() || `the server answered ${answer.status}`);
  return answer.blob();
}

export function download(blob: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
