// The picture: takes binary messages, draws when something has changed, and knows which frame belongs to which topology.

import * as THREE from "three";

import type { BinaryMessage, Command, Frame, Hello, Topology, Vec3 } from "../protocol";
import { isOpen } from "../store";
import type { Store } from "../store";
import { Bands } from "./bands";
import type { Band } from "./bands";
import { CameraRig } from "./camera";
import type { Covered } from "./camera";
import { FrontLines } from "./front";
import { Motion } from "./motion";
import { pick, surfacePoint } from "./pick";
import { PullHand } from "./pull";
import { Stage } from "./stage";
import { SurfaceMesh } from "./surface";

export class Viewer {
  readonly rig: CameraRig;
  /** Redraws since the page was loaded. */
  redraws = 0;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly stage = new Stage();
  private readonly front = new FrontLines();
  private readonly bands: Bands;
  private readonly hand: PullHand;
  private readonly motion = new Motion();
  private surface: SurfaceMesh | null = null;
  private topology: Topology | null = null; // of the frames shown
  private upcoming: Topology | null = null; // waits for its first frame
  private covered: Covered = { top: 0, right: 0, bottom: 0 };
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
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !frugal, alpha: true });
    this.renderer.shadowMap.enabled = !frugal;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.rig = new CameraRig(canvas, () => this.invalidate());
    this.bands = new Bands(labels);
    this.hand = new PullHand(canvas, this.rig.camera, {
      pick: (ray) => this.pick(ray),
      send,
      enabled: () => isOpen(store.get()),
      changed: () => this.invalidate(),
      focus: (point) => (point ? this.rig.focus(point) : this.rig.goHome()),
    });
    this.scene.add(this.stage.object, this.front.object, this.bands.object);
    this.front.object.visible = false;
    store.watch(
      (s) => s.hello,
      (hello) => hello && this.welcome(hello),
    );
    store.watch(
      (s) => s.colouring,
      () => this.colour(),
    );
    store.watch(
      (s) => s.wireframe,
      (on) => this.showWireframe(on),
    );
    store.watch(
      (s) => s.dark,
      (dark) => {
        this.stage.theme(dark);
        this.front.theme(dark);
        this.invalidate();
      },
    );
    canvas.addEventListener("webglcontextrestored", () => {
      this.motion.touch();
      this.renderer.shadowMap.needsUpdate = true;
      this.invalidate();
    });
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.renderer.setAnimationLoop((now) => this.tick(now));
  }

  /** [m] between the lines of the ground's grid. */
  get gridSpacing(): number {
    return this.stage.spacing;
  }

  get frame(): Frame | null {
    return this.motion.frame;
  }

  /** Surface positions as they are drawn now, [S][3]. */
  get positions(): Float32Array | null {
    return this.surface?.positions ?? null;
  }

  /** Panels lie on these edges of the picture. */
  cover(covered: Covered): void {
    this.covered = covered;
    this.resize();
  }

  receive(message: BinaryMessage): void {
    if (message.kind === "model") {
      this.surface?.mesh.removeFromParent();
      this.surface?.dispose();
      this.surface = new SurfaceMesh(message, this.store.get().hello?.young_range ?? [1, 1]);
      this.surface.mesh.visible = false; // until there are positions
      this.scene.add(this.surface.mesh);
      this.topology = this.upcoming = null;
      this.motion.clear();
      this.front.object.visible = false;
      this.hand.drop();
    } else if (message.kind === "topology") {
      this.upcoming = message;
    } else {
      this.showFrame(message);
    }
  }

  /** The connection is gone: a pull cannot go on, the last picture stays. */
  interrupted(): void {
    this.hand.drop();
  }

  invalidate(): void {
    this.dirty = true;
  }

  private showFrame(frame: Frame): void {
    if (!this.surface) return;
    if (this.upcoming?.epoch === frame.epoch) {
      this.topology = this.upcoming;
      this.upcoming = null;
      this.front.setTopology(this.topology);
      this.colour();
    }
    if (this.topology?.epoch !== frame.epoch) return;
    this.motion.push(frame, performance.now());
    this.stage.lower(frame);
    this.surface.mesh.visible = true;
    this.front.object.visible = this.store.get().wireframe;
    this.invalidate();
  }

  private welcome(hello: Hello): void {
    const { rest_box: box, view } = hello;
    const place = JSON.stringify([hello.scene.name, box, view, hello.up]);
    if (place === this.place) return; // the same scene again, after a reconnection: keep the camera
    this.place = place;
    this.stage.fit(box, hello.up, view.eye);
    this.rig.setHome({
      eye: view.eye,
      target: view.target,
      fieldOfView: view.field_of_view,
      up: hello.up,
      radius: Math.max(1e-9, 0.5 * Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2])),
    });
  }

  private colour(): void {
    if (!this.surface || !this.topology) return;
    this.surface.colour(this.store.get().colouring, this.topology.surfaceLevel);
    // three uploads changed attributes of an object that casts shadows with the shadow's pass: without it, a frame late.
    this.renderer.shadowMap.needsUpdate = true;
    this.invalidate();
  }

  private showWireframe(on: boolean): void {
    this.front.object.visible = on && this.topology !== null;
    this.motion.touch(); // its vertices were not written while it was hidden
    this.invalidate();
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.frugal ? 1 : Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.front.resize(width, height, this.renderer.getPixelRatio());
    this.rig.resize(width, height, this.covered);
  }

  private tick(now: number): void {
    this.hand.tick(now);
    this.rig.tick(now);
    const moved = this.motion.moving;
    if (!moved && !this.dirty) return;
    this.dirty = false;
    if (moved && this.surface) {
      this.motion.sample(now, this.surface.positions, this.front.object.visible ? this.front.positions : null);
      this.surface.moved();
      this.front.moved();
      this.renderer.shadowMap.needsUpdate = true;
    }
    this.drawBands();
    this.renderer.render(this.scene, this.rig.camera);
    ++this.redraws;
  }

  /** The own pull follows the pointer at once; its force is the server's, from the frame's nearest pull. */
  private drawBands(): void {
    const bands: Band[] = [];
    const pulls = this.motion.frame?.pulls ?? new Float32Array(0);
    for (let i = 0; i < pulls.length; i += 7)
      bands.push({
        from: [pulls[i], pulls[i + 1], pulls[i + 2]],
        to: [pulls[i + 3], pulls[i + 4], pulls[i + 5]],
        force: pulls[i + 6],
      });
    const { grip } = this.hand;
    if (grip && this.surface) {
      const from = surfacePoint(this.surface.positions, this.surface.triangles, grip.triangle, grip.barycentric);
      const away = (band: Band) => Math.hypot(...band.from.map((x, i) => x - from[i]));
      const mine = grip.begun
        ? bands.reduce((best, band, i) => (i === 0 || away(band) < away(bands[best]) ? i : best), 0)
        : -1;
      const force = mine >= 0 && bands.length > 0 ? bands.splice(mine, 1)[0].force : null;
      bands.unshift({ from, to: grip.target, force });
    }
    this.bands.update(bands, grip ? 1 : 0, this.rig, this.canvas.clientWidth, this.canvas.clientHeight);
  }

  private pick(ray: THREE.Ray): ReturnType<typeof pick> {
    if (!this.surface?.mesh.visible) return null;
    const { origin, direction } = ray;
    return pick(this.surface.positions, this.surface.triangles, origin.toArray() as Vec3, direction.toArray() as Vec3);
  }
}
