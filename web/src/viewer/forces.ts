// Forces that stay. Shift-drag on the object makes one; later on its arrow's head is dragged to change it, its foot to move it
// over the surface; the selected one is removed by Delete. The numbers are the server's and shared by all viewers (message "settings").

import * as THREE from "three";

import type { Command, Force, Vec3 } from "../messages";
import type { Hit } from "./pick";
import { isReplayed } from "./replay";

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

type Part = "head" | "foot";
// [px] around them; less around a foot, as beside it one pulls the object.
const REACH: Record<Part, number> = { head: 16, foot: 8 };
const SLACK = 4; // [px]

export class ForceHand {
  /** [N] of a force whose arrow is one metre long. */
  newtonsPerMetre = 1;
  private radius = 1; // [m] of the object
  /** What is being dragged, ahead of the server. */
  held: Force | null = null;
  private isNew = false;
  private part: Part = "head"; // that is dragged
  private pointer = -1;
  private start: [number, number] = [0, 0];
  private at = new THREE.Vector3();
  private plane = new THREE.Plane();
  private sent: Force | null = null;

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
    this.radius = radius;
  }

  tip(at: Vec3, value: Vec3): Vec3 {
    return [0, 1, 2].map((i) => at[i] + value[i] / this.newtonsPerMetre) as unknown as Vec3;
  }

  /** At most one command for each redraw. */
  tick(): void {
    if (!this.held || this.sent === this.held || (this.isNew && !this.sent)) return;
    this.sent = this.held;
    this.events.send({ command: "force_move", ...this.held });
  }

  /** A force without a drag: on what a ray hits, to the right, as long as it is well seen. */
  add(ray: THREE.Ray): void {
    const hit = this.events.enabled() ? this.events.pick(ray) : null;
    if (!hit) return;
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    const value = right.multiplyScalar(0.4 * this.radius * this.newtonsPerMetre).toArray() as unknown as Vec3;
    const force = this.nextNumber();
    this.events.send({ command: "force_add", force, triangle: hit.triangle, barycentric: hit.barycentric, value });
    this.events.select(force);
  }

  drop(): void {
    this.held = null;
    this.pointer = -1;
    this.element.classList.remove("pulling");
    this.events.changed();
  }

  private down(event: PointerEvent): void {
    if (isReplayed(event) || event.target !== this.element || event.button !== 0 || this.held || !this.events.enabled())
      return;
    const known = this.partUnder(event);
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
    this.part = known?.part ?? "head";
    this.sent = known?.force ?? null;
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
      this.held = { force: this.nextNumber(), triangle: hit.triangle, barycentric: hit.barycentric, value: [0, 0, 0] };
    }
    if (this.held) this.events.select(this.held.force);
    this.events.changed();
  }

  private move(event: PointerEvent): void {
    if (!this.held || event.pointerId !== this.pointer) {
      if (!this.held && event.buttons === 0)
        this.element.classList.toggle("over-arrow", this.partUnder(event) !== null);
      return;
    }
    if (this.part === "foot") {
      const hit = this.events.pick(this.events.ray(event));
      if (hit) this.held = { ...this.held, triangle: hit.triangle, barycentric: hit.barycentric };
      this.events.changed();
      return;
    }
    if (!this.sent && Math.hypot(event.clientX - this.start[0], event.clientY - this.start[1]) < SLACK) return;
    const tip = this.events.ray(event).intersectPlane(this.plane, new THREE.Vector3());
    if (!tip) return;
    const value = tip.sub(this.at).multiplyScalar(this.newtonsPerMetre).toArray() as unknown as Vec3;
    this.held = { ...this.held, value };
    if (this.isNew && !this.sent) {
      this.sent = this.held;
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

  /** The nearest end of an arrow. */
  private partUnder(event: MouseEvent): { force: Force; at: Vec3; part: Part } | null {
    const box = this.element.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    let best: ReturnType<ForceHand["partUnder"]> = null;
    let nearest = Infinity;
    for (const { force, at } of this.events.forces())
      for (const [part, end] of [
        ["head", this.tip(at, force.value)],
        ["foot", at],
      ] as const) {
        const [px, py] = this.events.project(new THREE.Vector3().fromArray(end));
        const away = Math.hypot(px - x, py - y);
        if (away < REACH[part] && away < nearest) [best, nearest] = [{ force, at, part }, away];
      }
    return best;
  }

  private nextNumber(): number {
    return 1 + Math.max(-1, ...this.events.forces().map(({ force }) => force.force));
  }
}
