// Pictures to keep: one, drawn by the server with the page's camera or as the canvas shows it; or all of a recording. The
// server's pictures show what the panels leave free of the page's, so both have the object at the same place.

import type { CameraKey } from "./camera_path";
import { planeOf } from "./cut";
import type { CutPlane, Vec3 } from "./messages";
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

/** Whether the server can draw what is shown: it knows the present only, and no solid tets. */
export const serverDraws = ({ shape, scrub }: Readonly<State>): boolean => shape === "surface" && scrub === null;

/** The query of /snapshot.png. */
export function snapshotQuery(state: Readonly<State>, framing: Framing): string {
  const background = state.transparent ? "transparent" : state.dark ? "dark" : "light";
  return query(framing, { ...viewOf(state, framing), colouring: state.colouring, background });
}

/** The query of a recording's pictures and of its video. Colours are those that were recorded; the camera is the page's, moved as while
 * it recorded, when the recording is of the page's scene, and the scene's own otherwise. */
export function exportQuery(
  state: Readonly<State>,
  framing: Framing,
  name: string,
  path: readonly CameraKey[] = [],
): string {
  const background = state.dark ? "dark" : "light";
  if (!state.hello || !isRecordingOf(state.hello.scene.name, name)) return query(framing, { background });
  const short = (vector: Vec3) => vector.map((x) => Number(x.toPrecision(5)));
  const keyframes = path.map(({ time, eye, target }) => ({
    time: Number(time.toFixed(3)),
    eye: short(eye),
    target: short(target),
  }));
  return query(framing, { ...viewOf(state, framing), background, ...(keyframes.length ? { keyframes } : {}) });
}

/** The server's list has names only. Those that it makes itself are SCENE-DATE-TIME, the scene's name as letters of a file's. */
export function isRecordingOf(scene: string, name: string): boolean {
  const letters = String.fromCharCode(...new TextEncoder().encode(scene).slice(0, 40)).replace(/[^\w.-]/g, "-");
  return name.startsWith(letters) && /^-\d{8}-\d{6}(\.tfr)?$/.test(name.slice(letters.length));
}

function viewOf(state: Readonly<State>, { eye, target, covered, height, field_of_view }: Framing) {
  const free = (height - covered.top - covered.bottom) / height;
  const half = Math.tan((field_of_view * Math.PI) / 360) * free;
  return {
    eye,
    target,
    field_of_view: Math.min(120, Math.max(5, (2 * Math.atan(half) * 180) / Math.PI)),
    wireframe: state.wireframe,
    ...cutFor(state),
  };
}

/** What a query does not say is as in the scene: its cut is undone by one that lies far beside the object. */
function cutFor({ cut, hello }: Readonly<State>): { cut?: CutPlane } {
  if (cut && hello) return { cut: planeOf(cut, hello.rest_box) };
  return hello?.view.cut ? { cut: { point: [1e6, 0, 0], normal: [1, 0, 0] } } : {};
}

function query({ width, height, covered }: Framing, view: object): string {
  const side = (pixels: number) => String(Math.min(4096, Math.max(16, Math.round(pixels))));
  return new URLSearchParams({
    w: side(width - covered.left - covered.right),
    h: side(height - covered.top - covered.bottom),
    view: JSON.stringify(view),
  }).toString();
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
