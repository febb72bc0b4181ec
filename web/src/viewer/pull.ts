// The hand: a left drag (or a finger) that starts on the object grabs that point of its surface and pulls it in the plane
// that faces the camera. A drag that starts elsewhere is left to the camera. Nothing is sent before the pointer has moved,
// so a click or a double-click does not disturb the object. Without a pointer: a key grabs, arrow keys move the hand along the
// picture's axes, and the pull ends when it is let go or when the keyboard goes elsewhere.

import * as THREE from "three";

import type { Command, Vec3 } from "../messages";
import type { Hit } from "./pick";
import { isReplayed, replay } from "./replay";

export interface Grip {
  pull: number;
  triangle: number;
  barycentric: Vec3;
  target: Vec3; // [m] the hand
  begun: boolean; // the server knows of it
  byKeys: boolean;
}

export interface PullEvents {
  /** The surface point under a ray, or null. */
  pick: (ray: THREE.Ray) => Hit | null;
  ray: (event: MouseEvent) => THREE.Ray;
  send: (command: Command) => void;
  /** False: nothing can be pulled now. */
  enabled: () => boolean;
  changed: () => void;
  focus: (point: Vec3 | null) => void;
  /** A pull by keys has begun or ended. */
  keyed: (on: boolean) => void;
}

const SLACK = 3; // [px] a click may wander this far
const LOOK_INTERVAL = 60; // [ms] between looks for the object under the pointer: some milliseconds on large surfaces

export class PullHand {
  grip: Grip | null = null;
  private pointer = -1;
  private start: [number, number] = [0, 0];
  private plane = new THREE.Plane();
  private sent: Vec3 | null = null;
  private hover: PointerEvent | null = null;
  private looked = 0;
  private next = 0;
  private first: PointerEvent | null = null; // where the finger that holds the grip is

  constructor(
    private readonly element: HTMLElement,
    private readonly camera: THREE.Camera,
    private readonly events: PullEvents,
  ) {
    // On the parent and while capturing: before the camera's own listeners see the event.
    const parent = element.parentElement ?? element;
    parent.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    element.addEventListener("pointermove", (event) => this.move(event));
    element.addEventListener("pointerup", (event) => this.up(event));
    element.addEventListener("pointercancel", (event) => this.up(event));
    element.addEventListener("lostpointercapture", (event) => this.up(event));
    element.addEventListener("dblclick", (event) =>
      this.events.focus(this.events.pick(this.events.ray(event))?.point ?? null),
    );
    element.addEventListener("blur", () => this.letGo());
    element.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Once per turn of the drawing loop, at `now` [ms]: at most one pull_move, now and then a look under the pointer. */
  tick(now: number): void {
    const { grip, hover } = this;
    if (grip?.begun && this.sent !== grip.target) {
      this.sent = grip.target;
      this.events.send({ command: "pull_move", pull: grip.pull, target: grip.target });
    }
    if (hover && !grip && now - this.looked > LOOK_INTERVAL) {
      this.hover = null;
      this.looked = now;
      const over = this.events.enabled() && this.events.pick(this.events.ray(hover)) !== null;
      this.element.classList.toggle("over-object", over);
    }
  }

  /** Grabs what a ray hits, for `nudge` to pull. */
  grab(ray: THREE.Ray): void {
    const hit = this.grip || !this.events.enabled() ? null : this.events.pick(ray);
    if (!hit) return;
    const { triangle, barycentric, point: target } = hit;
    this.grip = { pull: this.next++, triangle, barycentric, target, begun: true, byKeys: true };
    this.sent = target;
    this.events.send({ command: "pull_begin", pull: this.grip.pull, triangle, barycentric, target });
    this.element.focus({ preventScroll: true }); // so that leaving it is noticed
    this.events.keyed(true);
    this.events.changed();
  }

  /** Moves the hand that keys hold [m] to the right, up and towards the viewer. */
  nudge(...way: Vec3): void {
    const { grip } = this;
    if (!grip?.byKeys) return;
    this.camera.updateMatrixWorld();
    const target = new THREE.Vector3(...grip.target);
    way.forEach((length, axis) =>
      target.addScaledVector(new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, axis), length),
    );
    grip.target = target.toArray();
    this.events.changed();
  }

  /** Ends a pull by keys. */
  letGo(): void {
    if (this.grip?.byKeys) this.release();
  }

  /** Ends any pull. */
  release(): void {
    const { grip } = this;
    this.drop();
    if (grip?.begun) this.events.send({ command: "pull_end", pull: grip.pull });
  }

  /** Lets go without telling the server, which has ended the pull itself or is not there. */
  drop(): void {
    if (this.grip?.byKeys) this.events.keyed(false);
    this.grip = this.first = null;
    this.pointer = -1;
    this.element.classList.remove("pulling");
    this.events.changed();
  }

  private down(event: PointerEvent): void {
    if (isReplayed(event)) return;
    if (this.grip && !this.grip.byKeys && event.pointerType === "touch" && event.pointerId !== this.pointer) {
      this.handOver();
      return;
    }
    const plain = event.button === 0 && !event.shiftKey && !event.ctrlKey && !event.metaKey;
    if (event.target !== this.element || !plain || this.grip || !this.events.enabled()) return;
    const hit = this.events.pick(this.events.ray(event));
    if (!hit) return;
    event.stopPropagation();
    this.element.setPointerCapture(event.pointerId);
    this.element.classList.add("pulling");
    this.pointer = event.pointerId;
    this.start = [event.clientX, event.clientY];
    this.first = event;
    const normal = this.camera.getWorldDirection(new THREE.Vector3());
    this.plane.setFromNormalAndCoplanarPoint(normal, new THREE.Vector3(...hit.point));
    this.grip = {
      pull: this.next++,
      triangle: hit.triangle,
      barycentric: hit.barycentric,
      target: hit.point,
      begun: false,
      byKeys: false,
    };
    this.events.changed();
  }

  /** A second finger means the camera: the pull ends, and the camera learns of the first finger too. */
  private handOver(): void {
    const { first } = this;
    this.release();
    if (first) replay(this.element, first);
  }

  private move(event: PointerEvent): void {
    const grip = this.grip;
    if (!grip) {
      if (event.buttons === 0 && event.pointerType === "mouse") this.hover = event;
      return;
    }
    if (event.pointerId !== this.pointer) return;
    this.first = event;
    if (!grip.begun && Math.hypot(event.clientX - this.start[0], event.clientY - this.start[1]) < SLACK) return;
    const target = this.events.ray(event).intersectPlane(this.plane, new THREE.Vector3());
    if (!target) return;
    grip.target = [target.x, target.y, target.z];
    if (!grip.begun) {
      grip.begun = true;
      this.sent = grip.target;
      const { pull, triangle, barycentric } = grip;
      this.events.send({ command: "pull_begin", pull, triangle, barycentric, target: grip.target });
    }
    this.events.changed();
  }

  private up(event: PointerEvent): void {
    if (this.grip && event.pointerId === this.pointer) this.release();
  }
}
