// P: what is under the pointer stays where it is, or becomes free again.

import type * as THREE from "three";

import type { Command, Pin, Vec3 } from "../messages";
import { can } from "../store";
import type { Store } from "../store";
import type { Hit } from "./pick";

export interface PinEvents {
  pick: (ray: THREE.Ray) => Hit | null;
  send: (command: Command) => void;
  /** Where a pin's point is now [m]. */
  place: (pin: Pin) => Vec3;
}

export class PinHand {
  /** [m] around the point, in the shape at rest. */
  radius = 0.1;

  constructor(
    private readonly store: Store,
    private readonly events: PinEvents,
  ) {}

  /** `pin`: true to hold, false to free, undefined for the other of what was said of this place last. */
  act(ray: THREE.Ray, pin?: boolean): void {
    if (!can(this.store.get(), "edit")) return;
    const hit = this.events.pick(ray);
    if (!hit) return;
    const { triangle, barycentric } = hit;
    const away = (other: Pin) => Math.hypot(...this.events.place(other).map((x, i) => x - hit.point[i]));
    const hold = pin ?? !isHeld(this.store.get().settings?.pins ?? [], away);
    this.events.send({ command: hold ? "pin" : "unpin", triangle, barycentric, radius: this.radius });
  }
}

/** Whether the last word on a place was to hold it; `away`: how far a pin is from there [m]. What is held does not deform. */
export const isHeld = (pins: readonly Pin[], away: (pin: Pin) => number): boolean =>
  pins.findLast((pin) => away(pin) <= pin.radius)?.pinned ?? false;
