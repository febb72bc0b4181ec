// What hands do at the picture: pull, put forces, pin, make stiffer or softer. All of them share the canvas, the ray under the pointer and the server.

import * as THREE from "three";

import type { Command, Hello } from "../messages";
import { PartEdits } from "../part_edits";
import { regionRadius, snapped } from "../parts";
import type { Place } from "../parts";
import { can, isOpen, toolOf } from "../store";
import type { Store, Tool } from "../store";
import { forcesOf } from "./annotations";
import type { Body } from "./body";
import type { CameraRig } from "./camera";
import { ForceHand } from "./forces";
import type { Hit } from "./pick";
import { PinHand } from "./pins";
import { PullHand } from "./pull";
import { StiffnessHand } from "./stiffness";
import { ToolHand } from "./tools";

export interface HandEvents {
  pick: (ray: THREE.Ray) => Hit | null;
  send: (command: Command) => void;
  changed: () => void;
}

export class Hands {
  readonly pull: PullHand;
  readonly forces: ForceHand;
  readonly pins: PinHand;
  readonly stiffness: StiffnessHand;
  readonly partEdits: PartEdits;
  readonly tools: ToolHand;
  /** A key meant the object, but it is not there. */
  missed = (): void => undefined;
  private pointer: PointerEvent | null = null; // over the picture
  private step = 0.01; // [m] of a pull by keys

  constructor(
    canvas: HTMLCanvasElement,
    private readonly rig: CameraRig,
    private readonly store: Store,
    body: Body,
    private readonly events: HandEvents,
  ) {
    const shared = { ...events, ray: (event: MouseEvent) => rig.ray(event) };
    // A tool first: it is what the user has chosen.
    this.tools = new ToolHand(canvas, {
      ...shared,
      tool: () => toolOf(store.get()),
      region: (ray) => this.region(ray),
      use: (tool, ray) => this.use(tool, ray),
    });
    // The force hand before pulls: an arrow's ends lie over the object.
    this.forces = new ForceHand(canvas, rig.camera, {
      ...shared,
      enabled: () => can(store.get(), "edit") && store.get().scrub === null,
      select: (selectedForce) => store.set({ selectedForce }),
      forces: () => forcesOf(store.get(), body.surface, this.forces),
      project: (point) => rig.project(point),
    });
    this.pull = new PullHand(canvas, rig.camera, {
      ...shared,
      enabled: () => isOpen(store.get()) && store.get().scrub === null && toolOf(store.get()) === null,
      // Two quick taps with a tool are two taps.
      focus: (point) => toolOf(store.get()) === null && (point ? rig.focus(point) : rig.goHome()),
      keyed: (pullsByKeys) => store.set({ pullsByKeys }),
    });
    this.pins = new PinHand(store, { ...events, place: (pin) => body.point(pin) });
    this.partEdits = new PartEdits(store, events.send);
    this.stiffness = new StiffnessHand(store, this.partEdits, { ...events, place: (part) => body.point(part) });
    let told = store.get().regionSize;
    store.watch(
      (s) => s.regionSize,
      (size) => {
        if (size !== told) this.tools.flash(performance.now());
        told = size;
      },
    );
    canvas.addEventListener("pointermove", (event) => this.point(event));
    canvas.addEventListener("pointerleave", () => this.point(null));
  }

  /** Of a new scene: how large its object is, and how stiff. */
  scale({ rest_box: box, young_range }: Hello): void {
    const radius = Math.max(1e-9, 0.5 * Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]));
    this.forces.scale(young_range[0], radius);
    this.step = 0.04 * radius;
  }

  /** By key: on what is under the pointer, or in the picture's middle. */
  pin(hold?: boolean): void {
    this.act((ray) => this.pins.act(ray, hold));
  }

  newForce(): void {
    this.act((ray) => this.forces.add(ray));
  }

  stiffen(direction: 1 | -1): void {
    this.act((ray) => this.stiffness.act(ray, direction));
  }

  grab(): void {
    if (this.pull.grip) return this.pull.letGo();
    if (this.store.get().scrub !== null) return;
    this.act((ray) => {
      this.store.set({ tool: null });
      this.pull.grab(ray);
    });
  }

  /** In steps to the right, up and towards the viewer. */
  movePull(right: number, up: number, nearer: number): void {
    this.pull.nudge(right * this.step, up * this.step, nearer * this.step);
  }

  letGo(): void {
    this.pull.letGo();
  }

  tick(now: number): void {
    this.tools.tick(now, () => this.under());
    this.pull.tick(now);
    this.forces.tick();
  }

  /** The connection is gone, or another moment is shown: nothing that is held goes on. A server that is there may not know: the same
   * scene has come again, or the pull was begun after its reset. */
  drop(): void {
    if (isOpen(this.store.get())) this.pull.release();
    else this.pull.drop();
    this.forces.drop();
  }

  /** By key: on what is meant, or it is said that nothing is. */
  private act(what: (ray: THREE.Ray) => void): void {
    const ray = this.under();
    if (isOpen(this.store.get()) && !this.events.pick(ray)) this.missed();
    else what(ray);
  }

  private point(event: PointerEvent | null): void {
    this.pointer = event;
    if (this.store.get().pointing !== (event !== null)) this.store.set({ pointing: event !== null });
  }

  private use(tool: Tool, ray: THREE.Ray): void {
    if (tool === "force") {
      this.forces.add(ray);
      this.store.set({ tool: null }); // the next drag is for the new arrow
    } else if (tool === "pin") this.pins.act(ray);
    else this.stiffness.act(ray, tool === "stiffer" ? 1 : -1);
  }

  private region(ray: THREE.Ray): Place | null {
    const { hello, regionSize, tool } = this.store.get();
    const part = tool === "pin" ? null : this.stiffness.under(ray);
    const hit = part || !hello ? null : this.events.pick(ray);
    if (!hit || !hello) return part;
    return { triangle: hit.triangle, barycentric: snapped(hit.barycentric), radius: regionRadius(hello, regionSize) };
  }

  /** Under the pointer; without one in the middle of what the panels leave free. */
  private under(): THREE.Ray {
    if (this.pointer) return this.rig.ray(this.pointer);
    const { camera } = this.rig;
    camera.updateMatrixWorld();
    return new THREE.Ray(camera.position.clone(), camera.getWorldDirection(new THREE.Vector3()));
  }
}
