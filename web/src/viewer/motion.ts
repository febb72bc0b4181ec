// Turns frames that arrive now and then into a picture that moves at every redraw: shows the stretch from the last but
// one frame to the newest, one frame interval late. The packed frames are mixed and unpacked in a single pass.
//
// The surface is the same in all frames of a model, so it is mixed across front changes as well; the front's vertices are
// mixed only within one epoch.

import type { Frame } from "../protocol";

const LONGEST_INTERVAL = 150; // [ms] a longer gap is a pause, not a slow stream: the next frame is shown at once

export class Motion {
  private before: Frame | null = null;
  private newest: Frame | null = null;
  private arrival = 0; // [ms] of the newest frame
  private interval = 16; // [ms] smoothed time between frames
  private settled = true; // the newest frame itself has been written

  /** Takes the next frame at time `now` [ms]. */
  push(frame: Frame, now: number): void {
    const last = this.newest;
    const gap = now - this.arrival;
    // Going back in time is a reset: jump.
    const continues = last !== null && frame.generation === last.generation && frame.time >= last.time;
    this.before = continues && gap < LONGEST_INTERVAL ? last : null;
    if (this.before) this.interval += 0.2 * (gap - this.interval);
    this.newest = frame;
    this.arrival = now;
    this.settled = false;
  }

  /** Shows a frame as it is, without a way to it. */
  jump(frame: Frame): void {
    this.before = null;
    this.newest = frame;
    this.settled = false;
  }

  clear(): void {
    this.before = this.newest = null;
    this.settled = true;
  }

  get frame(): Frame | null {
    return this.newest;
  }

  /** The next sample is wanted, though nothing has moved. */
  touch(): void {
    this.settled = this.newest === null;
  }

  /** False when the picture would not change any more. */
  get moving(): boolean {
    return !this.settled;
  }

  /** Writes positions for time `now` [ms]: surface [S][3], and front [N][4] (x y z and an unused 1) when it is given. */
  sample(now: number, surface: Float32Array, front: Float32Array | null): void {
    const { before, newest } = this;
    if (!newest) return;
    const alpha = before ? Math.min(1, Math.max(0, (now - this.arrival) / this.interval)) : 1;
    mix(before?.surface.length === newest.surface.length ? before : null, newest, "surface", alpha, surface, 3);
    if (front) mix(before?.epoch === newest.epoch ? before : null, newest, "front", alpha, front, 4);
    this.settled = alpha === 1;
  }
}

/** out = (1 - alpha) before + alpha newest, unpacked; `stride` floats for each vertex. */
function mix(
  before: Frame | null,
  newest: Frame,
  which: "surface" | "front",
  alpha: number,
  out: Float32Array,
  stride: number,
): void {
  const b = newest[which];
  const a = before?.[which] ?? b;
  const from = before ?? newest;
  const weight = before ? alpha : 1;
  const rest = 1 - weight;
  const low = [0, 1, 2].map((i) => rest * from.low[i] + weight * newest.low[i]);
  const sa = [0, 1, 2].map((i) => (rest * from.extent[i]) / 65535);
  const sb = [0, 1, 2].map((i) => (weight * newest.extent[i]) / 65535);
  const [lx, ly, lz] = low;
  const [ax, ay, az] = sa;
  const [bx, by, bz] = sb;
  for (let i = 0, o = 0; i < b.length; i += 3, o += stride) {
    out[o] = lx + ax * a[i] + bx * b[i];
    out[o + 1] = ly + ay * a[i + 1] + by * b[i + 1];
    out[o + 2] = lz + az * a[i + 2] + bz * b[i + 2];
  }
}
