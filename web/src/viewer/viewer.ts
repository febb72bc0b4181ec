// The picture: takes binary messages, draws when something has changed, and knows which frame belongs to which topology.

import * as THREE from "three";

import type { Command, Hello, SceneForce, Vec3 } from "../messages";
import type { BinaryMessage, Frame, Topology } from "../protocol";
import { isField, RangeFollower } from "../scale";
import type { Framing } from "../snapshot";
import type { State, Store } from "../store";
import { Body } from "./body";
import { CameraRig } from "./camera";
import type { Covered } from "./camera";
import { Hands } from "./hands";
import { History } from "./history";
import { Motion } from "./motion";
import { Overlay } from "./overlay";
import { pick } from "./pick";
import type { Hit } from "./pick";
import { SceneForces } from "./scene_forces";
import { Stage } from "./stage";

export class Viewer {
  readonly rig: CameraRig;
  readonly hands: Hands;
  /** The last seconds. */
  readonly history = new History();
  /** Redraws since the page was loaded. */
  redraws = 0;
  /** A frame, and with it all before it, has been drawn. */
  drawn: (sequence: number) => void = () => undefined;
  cameraMoved = (): void => undefined;
  /** [ms] of the main thread for the last redraws with a new shape: mixing, unpacking and normals, without drawing. */
  readonly costs: number[] = [];
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly stage = new Stage();
  private readonly body = new Body();
  private readonly overlay: Overlay;
  private readonly sceneForces = new SceneForces();
  private readonly motion = new Motion();
  private readonly ranges = new RangeFollower();
  private topology: Topology | null = null; // of the newest frame
  private upcoming: Topology | null = null; // waits for its first frame
  private newest: Frame | null = null;
  private told: Frame | null = null; // the last that `drawn` has heard of
  private anchored: readonly SceneForce[] | undefined; // the scene's forces whose places on the surface are known
  private covered: Covered = { top: 0, left: 0, right: 0, bottom: 0 };
  private dirty = true;
  private place = "";

  /** `frugal`: no smoothed edges, no shadow, one pixel a pixel. Throws when the browser has no WebGL 2. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    labels: HTMLElement,
    private readonly store: Store,
    send: (command: Command) => void,
    private readonly frugal: boolean,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !frugal, alpha: true, stencil: true });
    this.renderer.localClippingEnabled = true;
    this.renderer.shadowMap.enabled = !frugal;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.rig = new CameraRig(canvas, () => {
      this.invalidate();
      this.cameraMoved();
    });
    this.overlay = new Overlay(labels);
    const events = { pick: (ray: THREE.Ray) => this.pick(ray), send, changed: () => this.invalidate() };
    this.hands = new Hands(canvas, this.rig, store, this.body, events);
    this.scene.add(this.stage.object, this.body.object, this.overlay.object);
    this.follow();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.renderer.setAnimationLoop((now) => this.tick(now));
  }

  /** [m] between the lines of the ground's grid. */
  get gridSpacing(): number {
    return this.stage.spacing;
  }

  /** What is shown. */
  get frame(): Frame | null {
    return this.motion.frame;
  }

  /** Surface positions as they are drawn now, [S][3]. */
  get positions(): Float32Array | null {
    return this.body.surface?.positions ?? null;
  }

  /** What is drawn and held: buffers by three's count, solid tets. */
  get census(): { geometries: number; textures: number; programs: number; tets: number } {
    const { memory, programs } = this.renderer.info;
    return { ...memory, programs: programs?.length ?? 0, tets: this.body.tetCount };
  }

  /** What the camera sees, for a picture of the same. */
  get framing(): Framing {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return { ...this.rig.view, width, height, covered: this.covered };
  }

  /** The picture as it is now, as a PNG. */
  toBlob(): Promise<Blob | null> {
    this.draw(performance.now());
    return new Promise((resolve) => this.canvas.toBlob(resolve));
  }

  /** Panels lie on these edges of the picture. */
  cover(covered: Covered): void {
    this.covered = covered;
    this.resize();
  }

  receive(message: BinaryMessage): void {
    if (message.kind === "model") {
      this.body.setModel(message);
      this.topology = this.upcoming = this.newest = null;
      this.motion.clear();
      this.history.clear();
      this.interrupted();
    } else if (message.kind === "topology") {
      this.upcoming = message;
    } else {
      this.receiveFrame(message);
    }
  }

  /** The connection is gone: a pull cannot go on, the last picture stays. */
  interrupted(): void {
    this.hands.drop();
  }

  invalidate(): void {
    this.dirty = true;
  }

  private follow(): void {
    const { store } = this;
    store.watch(
      (s) => s.hello,
      (hello) => hello && this.welcome(hello),
    );
    for (const part of ["shape", "wireframe", "cut", "explode"] as const)
      store.watch(
        (s) => s[part],
        () => this.showView(),
      );
    for (const part of ["colouring", "fieldRange"] as const)
      store.watch(
        (s) => s[part],
        () => this.showView(true),
      );
    store.watch(
      (s) => s.scrub,
      (time) => this.scrub(time),
    );
    for (const part of ["simulation", "settings", "selectedForce"] as const)
      store.watch(
        (s) => s[part],
        () => this.invalidate(),
      );
    store.watch(
      (s) => s.dark,
      (dark) => {
        this.stage.theme(dark);
        this.body.theme(dark);
        this.invalidate();
      },
    );
    this.canvas.addEventListener("webglcontextrestored", () => this.showView());
  }

  private receiveFrame(frame: Frame): void {
    if (!this.body.surface) return;
    if (this.upcoming?.epoch === frame.epoch) {
      this.topology = this.upcoming;
      this.upcoming = null;
    }
    if (this.topology?.epoch !== frame.epoch) return;
    const now = performance.now();
    this.history.push(frame, this.topology, now);
    const back = this.newest !== null && frame.time < this.newest.time;
    this.newest = frame;
    if (back) {
      this.interrupted(); // a reset, by anybody, has ended all pulls
      this.store.set({ scrub: null }); // and what one looked back at is no more
    }
    if (this.store.get().scrub !== null) this.body.haunt(frame);
    else this.present(frame, this.topology, () => this.motion.push(frame, now));
    this.invalidate();
  }

  private present(frame: Frame, topology: Topology, move: () => void): void {
    const state = this.store.get();
    const first = this.motion.frame === null;
    const other = this.body.epoch !== topology.epoch;
    if (other) this.body.setTopology(topology, state);
    move();
    this.stage.lower(frame);
    if (first) this.body.show(state, true);
    const { values } = frame;
    const { fieldRange } = state;
    const range = values && { field: values.field, high: this.ranges.follow(values, performance.now()) };
    if (range?.field !== fieldRange?.field || range?.high !== fieldRange?.high) this.store.set({ fieldRange: range });
    if (other || first || isField(state.colouring)) this.colour();
  }

  private scrub(time: number | null): void {
    if (!this.body.surface || !this.newest || !this.topology) return;
    const past = time === null ? null : this.history.at(time);
    this.hands.pull.release();
    this.interrupted();
    const shown = past ?? { frame: this.newest, topology: this.topology };
    this.present(shown.frame, shown.topology, () => this.motion.jump(shown.frame));
    this.body.haunt(this.newest);
    this.showView();
  }

  private welcome(hello: Hello): void {
    const { rest_box: box, view } = hello;
    const place = JSON.stringify([hello.scene.name, box, view, hello.up]);
    if (place === this.place) return; // the same scene again, after a reconnection: keep the camera
    this.place = place;
    this.stage.fit(box, hello.up, view.eye);
    const radius = Math.max(1e-9, 0.5 * Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]));
    this.hands.scale(hello);
    const { eye, target, field_of_view: fieldOfView } = view;
    this.rig.setHome({ eye, target, fieldOfView, up: hello.up, radius });
  }

  private colour(): void {
    this.body.colour(this.store.get(), this.motion.frame);
    // three uploads changed attributes of an object that casts shadows with the shadow's pass: without it, a frame late.
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  private showView(coloured = false): void {
    if (coloured) this.colour();
    this.body.show(this.store.get());
    this.motion.touch(); // vertices were not written while they were hidden
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.frugal ? 1 : Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.body.lines.resize(width, height, this.renderer.getPixelRatio());
    this.rig.resize(width, height, this.covered);
  }

  private tick(now: number): void {
    this.hands.tick(now);
    this.rig.tick(now);
    const moved = this.motion.moving;
    // Before there is an object nothing is drawn: it would be an empty ground, and keep the first frame waiting.
    if ((moved || this.dirty) && this.motion.frame) this.draw(now);
  }

  /** The shape first: edges and tets of a new front may be there already whose vertices are not. */
  private draw(now: number): void {
    this.dirty = false;
    if (this.motion.moving) {
      const start = performance.now();
      this.body.sample(this.motion, now);
      if (this.costs.push(performance.now() - start) > 240) this.costs.shift();
      this.renderer.shadowMap.needsUpdate = true;
    }
    const { motion, body, hands, sceneForces, rig, canvas, newest } = this;
    const state = this.store.get();
    this.anchorForces(state);
    this.overlay.update({ state, frame: motion.frame, body, hands, sceneForces, rig, canvas });
    this.renderer.render(this.scene, this.rig.camera);
    ++this.redraws;
    if (newest && newest !== this.told) this.drawn(newest.sequence);
    this.told = newest;
  }

  /** Where the scene's forces act is said of the present: they are tied to the surface when it has been written as it is now. */
  private anchorForces({ simulation, scrub }: Readonly<State>): void {
    const forces = simulation?.forces;
    if (scrub !== null || forces === this.anchored) return;
    this.anchored = forces;
    this.sceneForces.set(forces ?? [], this.positions ?? new Float32Array(0));
  }

  private pick(ray: THREE.Ray): Hit | null {
    const { surface } = this.body;
    if (!surface || !this.motion.frame) return null;
    const { origin, direction } = ray;
    const hit = pick(surface.positions, surface.triangles, origin.toArray() as Vec3, direction.toArray() as Vec3);
    return hit && this.body.hides(new THREE.Vector3().fromArray(hit.point)) ? null : hit;
  }
}
