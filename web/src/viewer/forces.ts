// Forces that stay. Shift-drag on the object makes one, whose arrow is dragged by its head later on; the selected one is
// removed by Delete. The numbers are the server's and shared by all viewers (message "settings").

import * as THREE from "three";

import type { Command, Force, Vec3 } from "../messages";
import type { Hit } from "./pick";

export interface ForceEvents {
  pick: (ray: THREE.Ray) => Hit | null;
  ray: (event: MouseEvent) => THREE.Ray;
  send: (command: Command) => void;
  enabled: () => boolean;
  changed: () => void;
  select: (force: number | null) => void;
  /** All forces now, with where they act [m]. */
  forces: () => readonly { force: Force; at: Vec3 }[];
  /** Where a point is on the screen [CSS px]. */
  project: (point: THREE.Vector3) => [number, number];
}

const REACH = 16; // [px] around an arrow's head
const SLACK = 4; // [px]

export class ForceHand {
  /** [N] of a force whose arrow is one metre long. */
  newtonsPerMetre = 1;
  /** What is being dragged, ahead of the server. */
  held: Force | null = null;
  private isNew = false;
  private pointer = -1;
  private start: [number, number] = [0, 0];
  private at = new THREE.Vector3();
  private plane = new THREE.Plane();
  private sent: Vec3 | null = null;

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: THREE.Camera,
    private readonly events: ForceEvents,
  ) {
    const parent = element.parentElement ?? element;
    parent.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    element.addEventListener("pointermove", (event) => this.move(event));
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture"] as const)
      element.addEventListener(kind, (event) => this.up(event));
  }

  /** A good scale: an arrow as long as the object's radius strains a block of that size by a tenth. */
  scale(youngLow: number, radius: number): void {
    this.newtonsPerMetre = 0.1 * youngLow * radius;
  }

  tip(at: Vec3, value: Vec3): Vec3 {
    return [0, 1, 2].map((i) => at[i] + value[i] / this.newtonsPerMetre) as unknown as Vec3;
  }

  /** At most one command for each redraw. */
  tick(): void {
    if (!this.held || this.sent === this.held.value || (this.isNew && !this.sent)) return;
    this.sent = this.held.value;
    this.events.send({ command: "force_move", force: this.held.force, value: this.held.value });
  }

  drop(): void {
    this.held = null;
    this.pointer = -1;
    this.element.classList.remove("pulling");
    this.events.changed();
  }

  private down(event: PointerEvent): void {
    if (event.target !== this.element || event.button !== 0 || this.held || !this.events.enabled()) return;
    const known = this.headUnder(event);
    const hit = known ? null : event.shiftKey ? this.events.pick(this.events.ray(event)) : null;
    if (!known && !hit) {
      this.events.select(null);
      return;
    }
    event.stopImmediatePropagation(); // neither a pull nor the camera
    this.element.setPointerCapture(event.pointerId);
    this.element.classList.add("pulling");
    this.pointer = event.pointerId;
    this.start = [event.clientX, event.clientY];
    this.isNew = known === null;
    this.sent = known?.force.value ?? null;
    const normal = this.camera.getWorldDirection(new THREE.Vector3());
    if (known) {
      this.held = known.force;
      this.at.fromArray(known.at);
      this.plane.setFromNormalAndCoplanarPoint(
        normal,
        new THREE.Vector3().fromArray(this.tip(known.at, known.force.value)),
      );
    } else if (hit) {
      this.at.fromArray(hit.point);
      this.plane.setFromNormalAndCoplanarPoint(normal, this.at);
      const force = 1 + Math.max(-1, ...this.events.forces().map((f) => f.force.force));
      this.held = { force, triangle: hit.triangle, barycentric: hit.barycentric, value: [0, 0, 0] };
    }
    if (this.held) this.events.select(this.held.force);
    this.events.changed();
  }

  private move(event: PointerEvent): void {
    if (!this.held || event.pointerId !== this.pointer) {
      if (!this.held && event.buttons === 0)
        this.element.classList.toggle("over-arrow", this.headUnder(event) !== null);
      return;
    }
    if (!this.sent && Math.hypot(event.clientX - this.start[0], event.clientY - this.start[1]) < SLACK) return;
    const tip = this.events.ray(event).intersectPlane(this.plane, new THREE.Vector3());
    if (!tip) return;
    const value = tip.sub(this.at).multiplyScalar(this.newtonsPerMetre).toArray() as unknown as Vec3;
    this.held = { ...this.held, value };
    if (this.isNew && !this.sent) {
      this.sent = value;
      this.events.send({ command: "force_add", ...this.held });
    }
    this.events.changed();
  }

  private up(event: PointerEvent): void {
    if (!this.held || event.pointerId !== this.pointer) return;
    this.tick(); // the last word
    if (this.isNew && !this.sent) this.events.select(null);
    this.drop();
  }

  private headUnder(event: MouseEvent): { force: Force; at: Vec3 } | null {
    const box = this.element.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let best: { force: Force; at: Vec3 } | null = null;
    let nearest = REACH;
    for (const candidate of this.events.forces()) {
      const [px, py] = this.events.project(
        new THREE.Vector3().fromArray(this.tip(candidate.at, candidate.force.value)),
      );
      const away = Math.hypot(px - x, py - y);
      if (away < nearest) [best, nearest] = [candidate, away];
    }
    return best;
  }
}
