// What lies over the object in the picture: pulls, forces and pins, and the rims of parts of other stiffness.

import * as THREE from "three";

import type { Frame } from "../protocol";
import type { State } from "../store";
import { annotations } from "./annotations";
import { Bands } from "./bands";
import type { Body } from "./body";
import type { CameraRig } from "./camera";
import type { Hands } from "./hands";
import { Rims } from "./rims";
import type { SceneForces } from "./scene_forces";

export interface Scene {
  state: Readonly<State>;
  frame: Frame | null; // that is shown
  body: Body;
  hands: Hands;
  sceneForces: SceneForces;
  rig: CameraRig;
  canvas: HTMLCanvasElement;
}

export class Overlay {
  readonly object = new THREE.Group();
  private readonly bands: Bands;
  private readonly rims: Rims;

  constructor(labels: HTMLElement) {
    this.rims = new Rims(labels);
    this.bands = new Bands(labels);
    this.object.add(this.rims.object, this.bands.object);
  }

  update({ state, frame, body, hands, sceneForces, rig, canvas }: Scene): void {
    const { clientWidth: width, clientHeight: height } = canvas;
    const { surface } = body;
    const bands = annotations(state, frame, surface, hands.pull.grip, hands.forces, sceneForces);
    this.bands.update(bands, rig, width, height);
    if (!surface) return;
    this.rims.update({
      parts: state.settings?.stiffness_parts ?? [],
      preview: hands.tools.preview,
      surface,
      atRest: frame?.time === 0,
      rig,
      width,
      height,
      hides: state.cut ? (point) => body.hides(point) : null,
      apart: state.shape === "tets" && state.explode > 0,
    });
  }
}
