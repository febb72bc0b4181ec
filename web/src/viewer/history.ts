// The last seconds of what was shown, so that one can look back while the simulation goes on: frames as they came, each
// with its topology, which most share with the one before. Bounded in time and in bytes, whichever comes first.

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
  private readonly uses = new Map<Topology, number>(); // moments of each
  private bytes = 0;

  constructor(private readonly most = MOST_BYTES) {}

  push(frame: Frame, topology: Topology, arrival: number): void {
    const last = this.moments.at(-1)?.frame;
    // A reset or another scene: what was before is another story.
    if (last && (last.generation !== frame.generation || frame.time < last.time)) this.clear();
    // A frame that came again, with other values or after a pull was moved while paused: the newer one.
    if (last && last.time === frame.time && this.moments.length > 0) this.forget(this.moments.pop());
    this.moments.push({ frame, topology, arrival });
    this.bytes += sizeOf(frame.surface) + this.use(topology, 1);
    let old = 0;
    while (
      old < this.moments.length - 1 &&
      (arrival - this.moments[old].arrival > 1000 * SECONDS || this.bytes > this.most)
    )
      this.forget(this.moments[old++]);
    if (old) this.moments.splice(0, old);
  }

  clear(): void {
    this.moments = [];
    this.uses.clear();
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
    if (moment) this.bytes -= sizeOf(moment.frame.surface) + this.use(moment.topology, -1);
  }

  /** Bytes that come with a topology's first moment, or go with its last. */
  private use(topology: Topology, change: 1 | -1): number {
    const before = this.uses.get(topology) ?? 0;
    const after = before + change;
    if (after === 0) this.uses.delete(topology);
    else this.uses.set(topology, after);
    return before === 0 || after === 0 ? sizeOf(topology.edges) : 0;
  }
}

/** Of the whole message, which all its arrays lie in. */
const sizeOf = (array: Uint16Array | Uint32Array): number => array.buffer.byteLength;
