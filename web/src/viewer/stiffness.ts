// K: the region under the pointer becomes stiffer, with Shift softer.

import type * as THREE from "three";

import type { StiffnessPart, Vec3 } from "../messages";
import type { PartEdits } from "../part_edits";
import { partAt, regionRadius, snapped, without } from "../parts";
import { canScaleParts } from "../store";
import type { Store } from "../store";
import type { Hit } from "./pick";

export interface StiffnessEvents {
  pick: (ray: THREE.Ray) => Hit | null;
  /** Where a part's point is now [m]. */
  place: (part: StiffnessPart) => Vec3;
}

export class StiffnessHand {
  constructor(
    private readonly store: Store,
    private readonly edits: PartEdits,
    private readonly events: StiffnessEvents,
  ) {}

  act(ray: THREE.Ray, direction: 1 | -1): void {
    const found = this.find(ray);
    if (found) this.edits.step(found.part, found.below, direction);
  }

  /** The part that is meant there, as stiff as it is now. */
  under(ray: THREE.Ray): StiffnessPart | null {
    return this.find(ray)?.part ?? null;
  }

  private find(ray: THREE.Ray): { part: StiffnessPart; below: number } | null {
    const { hello, regionSize, scrub } = this.store.get();
    const hit = hello && scrub === null && canScaleParts(this.store.get()) ? this.events.pick(ray) : null;
    if (!hello || !hit) return null;
    const away = (part: StiffnessPart) => Math.hypot(...this.events.place(part).map((x, i) => x - hit.point[i]));
    const place = { triangle: hit.triangle, barycentric: snapped(hit.barycentric) };
    const { parts } = this.edits;
    const part = partAt(parts, place, regionRadius(hello, regionSize), away);
    return { part, below: without(parts, part, away) };
  }
}
