// P: what is under the pointer stays where it is, or becomes free again.

import type * as THREE from "three";

import type { Command, Pin, Vec3 } from "../messages";
import { regionRadius, snapped } from "../parts";
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
  constructor(
    private readonly store: Store,
    private readonly events: PinEvents,
  ) {}

  /** `pin`: true to hold, false to free, undefined for the other of what was said of this place last. */
  act(ray: THREE.Ray, pin?: boolean): void {
    const { hello, regionSize, scrub, settings } = this.store.get();
    if (!hello || scrub !== null || !can(this.store.get(), "edit")) return;
    const hit = this.events.pick(ray);
    if (!hit) return;
    const away = (other: Pin) => Math.hypot(...this.events.place(other).map((x, i) => x - hit.point[i]));
    const last = lastWord(settings?.pins ?? [], away);
    const hold = pin ?? !last?.pinned;
    // A pin is let go as a whole: a region around the pointer would leave a crescent of it.
    const { triangle, barycentric, radius } =
      !hold && last?.pinned
        ? last
        : { ...hit, barycentric: snapped(hit.barycentric), radius: regionRadius(hello, regionSize) };
    this.events.send({ command: hold ? "pin" : "unpin", triangle, barycentric, radius });
  }
}

/** What was said of a place last; `away`: how far a pin is from there [m]. What is held does not deform. */
export const lastWord = <P extends Pin>(pins: readonly P[], away: (pin: P) => number): P | undefined =>
  pins.findLast((pin) => away(pin) <= pin.radius);
