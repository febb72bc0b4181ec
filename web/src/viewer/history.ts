// The last seconds of what was shown, so that one can look back while the simulation goes on: frames as they came, each
// with its topology. Bounded in time and in bytes, whichever comes first.

import type { Frame, Topology } from "../protocol";

export const SECONDS = 20;
const MOST_BYTES = 96e6;

export interface Moment {
  frame: Frame;
  topology: Topology;
  arrival: number; // [ms]
}

export class History {
  private moments: Moment[] = [];
  private bytes = 0;

  push(frame: Frame, topology: Topology, arrival: number): void {
    const last = this.moments.at(-1)?.frame;
    // A reset or another scene: what was before is another story.
    if (last && (last.generation !== frame.generation || frame.time < last.time)) this.clear();
    // A frame that came again, with other values or after a pull was moved while paused: the newer one.
    if (last && last.time === frame.time && this.moments.length > 0) this.forget(this.moments.pop());
    this.moments.push({ frame, topology, arrival });
    this.bytes += sizeOf(frame);
    let old = 0;
    while (
      old < this.moments.length - 1 &&
      (arrival - this.moments[old].arrival > 1000 * SECONDS || this.bytes > MOST_BYTES)
    )
      this.forget(this.moments[old++]);
    if (old) this.moments.splice(0, old);
  }

  clear(): void {
    this.moments = [];
    this.bytes = 0;
  }

  /** [s] simulated: the oldest and the newest moment. */
  get range(): readonly [number, number] {
    return [this.moments[0]?.frame.time ?? 0, this.moments.at(-1)?.frame.time ?? 0];
  }

  /** [s] simulated, of every moment. */
  get times(): number[] {
    return this.moments.map(({ frame }) => frame.time);
  }

  get length(): number {
    return this.moments.length;
  }

  /** The last moment that is not after this time [s], or the oldest. */
  at(time: number): Moment | null {
    if (this.moments.length === 0) return null;
    let [low, high] = [0, this.moments.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.moments[middle].frame.time <= time + 1e-9) low = middle;
      else high = middle - 1;
    }
    return this.moments[low];
  }

  private forget(moment: Moment | undefined): void {
    if (moment) this.bytes -= sizeOf(moment.frame);
  }
}

const sizeOf = (frame: Frame): number => frame.surface.buffer.byteLength;
