// How the camera moves while this page records, as keyframes for the recording's pictures and video: the recording itself
// belongs to all viewers, and each of them looks from elsewhere.
//
//     const path = new CameraPath();
//     path.sample(name, time, eye, target);       // now and then, while recording
//     path.keyframes(name);                       // [] when the camera stood still

import type { Vec3 } from "./messages";

export interface CameraKey {
  time: number; // [s] simulated
  eye: Vec3;
  target: Vec3;
}

const MOST = 24; // they have to fit into an address

export class CameraPath {
  private name = "";
  private keys: CameraKey[] = [];
  private apart = 0.2; // [s] simulated, at least, between two keys

  /** name: of the recording; another one begins anew. */
  sample(name: string, time: number, eye: Vec3, target: Vec3): void {
    if (name !== this.name) {
      this.name = name;
      this.keys = [];
      this.apart = 0.2;
    }
    const last = this.keys.at(-1);
    if (last && time < last.time + this.apart) return;
    const [before] = this.keys.slice(-2);
    // Of a camera that stands still the first and the last moment are enough.
    if (last && before && before !== last && same(before, last) && same(last, { time, eye, target })) this.keys.pop();
    this.keys.push({ time, eye, target });
    if (this.keys.length <= MOST) return;
    this.keys = this.keys.filter((_, i) => i % 2 === 0);
    this.apart *= 2;
  }

  /** Ascending in time. */
  keyframes(name: string): readonly CameraKey[] {
    const moved = this.keys.some((key) => !same(key, this.keys[0]));
    return name === this.name && moved ? this.keys : [];
  }
}

const same = (a: CameraKey, b: CameraKey): boolean =>
  [0, 1, 2].every((i) => a.eye[i] === b.eye[i] && a.target[i] === b.target[i]);
