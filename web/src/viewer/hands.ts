// What hands do at the picture: pull, put forces, pin. All of them share the canvas, the ray under the pointer and the server.

import * as THREE from "three";

import type { Command, Hello } from "../messages";
import { can, isOpen } from "../store";
import type { Store } from "../store";
import { forcesOf } from "./annotations";
import type { Body } from "./body";
import type { CameraRig } from "./camera";
import { ForceHand } from "./forces";
import type { Hit } from "./pick";
import { PinHand } from "./pins";
import { PullHand } from "./pull";

export interface HandEvents {
  pick: (ray: THREE.Ray) => Hit | null;
  send: (command: Command) => void;
  changed: () => void;
}

export class Hands {
  readonly pull: PullHand;
  readonly forces: ForceHand;
  readonly pins: PinHand;
  private pointer: PointerEvent | null = null; // over the picture

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly rig: CameraRig,
    store: Store,
    body: Body,
    events: HandEvents,
  ) {
    const shared = { ...events, ray: (event: MouseEvent) => rig.ray(event) };
    // The force hand first: an arrow's ends lie over the object.
    this.forces = new ForceHand(canvas, rig.camera, {
      ...shared,
      enabled: () => can(store.get(), "edit") && store.get().scrub === null,
      select: (selectedForce) => store.set({ selectedForce }),
      forces: () => forcesOf(store.get(), body.surface, this.forces),
      project: (point) => rig.project(point),
    });
    this.pull = new PullHand(canvas, rig.camera, {
      ...shared,
      enabled: () => isOpen(store.get()) && store.get().scrub === null,
      focus: (point) => (point ? rig.focus(point) : rig.goHome()),
    });
    this.pins = new PinHand(store, { ...events, place: (pin) => body.point(pin) });
    canvas.addEventListener("pointermove", (event) => (this.pointer = event));
    canvas.addEventListener("pointerleave", () => (this.pointer = null));
  }

  /** Of a new scene: how large its object is, and how stiff. */
  scale({ rest_box: box, young_range }: Hello): void {
    const radius = Math.max(1e-9, 0.5 * Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]));
    this.forces.scale(young_range[0], radius);
    this.pins.radius = 0.15 * radius;
  }

  /** By key: on what is under the pointer, or in the picture's middle. */
  pin(hold?: boolean): void {
    this.pins.act(this.under(), hold);
  }

  newForce(): void {
    this.forces.add(this.under());
  }

  tick(now: number): void {
    this.pull.tick(now);
    this.forces.tick();
  }

  /** The connection is gone, or another moment is shown: nothing that is held goes on. */
  drop(): void {
    this.pull.drop();
    this.forces.drop();
  }

  private under(): THREE.Ray {
    const { left, top, width, height } = this.canvas.getBoundingClientRect();
    return this.rig.ray(this.pointer ?? { clientX: left + width / 2, clientY: top + height / 2 });
  }
}
