// The camera and how one moves it: three's OrbitControls around any up axis, plus keys, focus and home.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

import type { Vec3 } from "../messages";

export interface Home {
  eye: Vec3; // [m]
  target: Vec3; // [m]
  fieldOfView: number; // [degrees] vertical, at the narrower side
  up: 0 | 1 | 2;
  radius: number; // [m] of the object
}

/** [CSS px] of the window's edges that panels lie on. */
export interface Covered {
  top: number;
  left: number;
  right: number;
  bottom: number;
}

const GLIDE = 280; // [ms]

export class CameraRig {
  readonly camera = new THREE.PerspectiveCamera();
  private controls: OrbitControls | null = null;
  private home: Home | null = null;
  private size: [number, number, Covered] = [1, 1, { top: 0, left: 0, right: 0, bottom: 0 }];
  private glide: { start: number; eye: [THREE.Vector3, THREE.Vector3]; target: [THREE.Vector3, THREE.Vector3] } | null =
    null;

  constructor(
    private readonly element: HTMLElement,
    private readonly changed: () => void,
  ) {}

  setHome(home: Home): void {
    this.home = home;
    this.controls?.dispose();
    this.camera.up.set(0, 0, 0).setComponent(home.up, 1);
    this.camera.position.fromArray(home.eye);
    // OrbitControls reads camera.up once: new controls for a new scene.
    const controls = new OrbitControls(this.camera, this.element);
    controls.target.fromArray(home.target);
    controls.mouseButtons = { LEFT: THREE.MOUSE.ROTATE, MIDDLE: THREE.MOUSE.PAN, RIGHT: THREE.MOUSE.ROTATE };
    controls.touches = { ONE: THREE.TOUCH.ROTATE, TWO: THREE.TOUCH.DOLLY_PAN };
    controls.zoomToCursor = true;
    controls.minDistance = 0.05 * home.radius;
    controls.maxDistance = 40 * home.radius;
    controls.addEventListener("change", this.changed);
    controls.addEventListener("start", () => (this.glide = null));
    this.camera.near = 0.02 * home.radius;
    this.camera.far = 80 * home.radius;
    this.controls = controls;
    controls.update();
    this.resize(...this.size);
  }

  /** Sizes in CSS px. The whole object fits into what the panels leave free, whatever its shape, and is centred there. */
  resize(width: number, height: number, covered: Covered): void {
    this.size = [width, height, covered];
    const free = [
      Math.max(80, width - covered.left - covered.right),
      Math.max(80, height - covered.top - covered.bottom),
    ];
    const half = Math.tan(THREE.MathUtils.degToRad((this.home?.fieldOfView ?? 35) / 2));
    const tangent = half * Math.max(1, free[1] / free[0]) * (height / free[1]);
    this.camera.fov = THREE.MathUtils.radToDeg(2 * Math.atan(tangent));
    this.camera.aspect = width / height;
    this.camera.setViewOffset(
      width,
      height,
      (covered.right - covered.left) / 2,
      (covered.bottom - covered.top) / 2,
      width,
      height,
    );
    this.changed();
  }

  /** Looks at a point from half as far. */
  focus(point: Vec3): void {
    if (!this.controls) return;
    const target = new THREE.Vector3().fromArray(point);
    const eye = this.camera.position.clone().sub(this.controls.target).multiplyScalar(0.6).add(target);
    this.glideTo(eye, target);
  }

  goHome(): void {
    if (this.home)
      this.glideTo(new THREE.Vector3().fromArray(this.home.eye), new THREE.Vector3().fromArray(this.home.target));
  }

  /** Angles in radians; zoom is a factor on the distance. */
  nudge(azimuth: number, polar: number, zoom = 1): void {
    if (!this.controls) return;
    this.glide = null;
    const toYUp = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    const offset = this.camera.position.clone().sub(this.controls.target).applyQuaternion(toYUp);
    const at = new THREE.Spherical().setFromVector3(offset);
    at.theta += azimuth;
    at.phi = THREE.MathUtils.clamp(at.phi + polar, 0.01, Math.PI - 0.01);
    at.radius *= zoom;
    offset.setFromSpherical(at).applyQuaternion(toYUp.invert());
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.changed();
  }

  /** Moves the view in the plane of the picture, in heights of what it shows at its target. */
  pan(right: number, up: number): void {
    if (!this.controls) return;
    this.glide = null;
    const { position, matrixWorld, fov } = this.camera;
    this.camera.updateMatrixWorld();
    const height = 2 * position.distanceTo(this.controls.target) * Math.tan(THREE.MathUtils.degToRad(fov / 2));
    const way = new THREE.Vector3();
    [right, up].forEach((length, axis) =>
      way.addScaledVector(new THREE.Vector3().setFromMatrixColumn(matrixWorld, axis), length * height),
    );
    position.add(way);
    this.controls.target.add(way);
    this.controls.update();
    this.changed();
  }

  /** Advances a glide; `now` [ms]. */
  tick(now: number): void {
    if (!this.glide || !this.controls) return;
    const t = Math.min(1, (now - this.glide.start) / GLIDE);
    const ease = t * t * (3 - 2 * t);
    this.camera.position.lerpVectors(...this.glide.eye, ease);
    this.controls.target.lerpVectors(...this.glide.target, ease);
    if (t === 1) this.glide = null;
    this.controls.update();
    this.changed();
  }

  /** The ray through a point of the screen. */
  ray({ clientX, clientY }: { clientX: number; clientY: number }): THREE.Ray {
    const box = this.element.getBoundingClientRect();
    const point = new THREE.Vector2(
      (2 * (clientX - box.left)) / box.width - 1,
      1 - (2 * (clientY - box.top)) / box.height,
    );
    const caster = new THREE.Raycaster();
    this.camera.updateMatrixWorld();
    caster.setFromCamera(point, this.camera);
    return caster.ray;
  }

  /** Where a point is on the screen, from the element's corner [CSS px]. */
  project(point: THREE.Vector3): [number, number] {
    const at = point.clone().project(this.camera);
    return [((at.x + 1) / 2) * this.element.clientWidth, ((1 - at.y) / 2) * this.element.clientHeight];
  }

  /** As in a scene's view: where the camera is, what it looks at [m], and its vertical angle [degrees]. */
  get view(): { eye: Vec3; target: Vec3; field_of_view: number } {
    const target = this.controls?.target ?? new THREE.Vector3();
    return {
      eye: this.camera.position.toArray() as unknown as Vec3,
      target: target.toArray() as unknown as Vec3,
      field_of_view: this.camera.fov,
    };
  }

  /** Eye and target when they are not those of home, else null. */
  get moved(): number[] | null {
    if (!this.home || !this.controls) return null;
    const now = [...this.camera.position.toArray(), ...this.controls.target.toArray()];
    const home = [...this.home.eye, ...this.home.target];
    return now.every((x, i) => Math.abs(x - home[i]) < 1e-3 * (this.home?.radius ?? 1)) ? null : now;
  }

  place(eye: Vec3, target: Vec3): void {
    if (!this.controls) return;
    this.glide = null;
    this.camera.position.fromArray(eye);
    this.controls.target.fromArray(target);
    this.controls.update();
    this.changed();
  }

  /** [m] in the world that one CSS pixel covers at this point. */
  metresPerPixel(point: THREE.Vector3, height: number): number {
    const depth = point.clone().sub(this.camera.position).dot(this.camera.getWorldDirection(new THREE.Vector3()));
    return (2 * Math.max(depth, this.camera.near) * Math.tan(THREE.MathUtils.degToRad(this.camera.fov / 2))) / height;
  }

  private glideTo(eye: THREE.Vector3, target: THREE.Vector3): void {
    if (!this.controls) return;
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.glide = {
      start: performance.now() - (still ? GLIDE : 0),
      eye: [this.camera.position.clone(), eye],
      target: [this.controls.target.clone(), target],
    };
    this.changed();
  }
}
