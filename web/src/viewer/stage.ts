// Where the object stands: neutral studio light, a ground with a fine grid that fades out, a soft shadow.

import * as THREE from "three";

import type { Vec3 } from "../messages";
import type { Frame } from "../protocol";

const SHADOW_TEXELS = 1024;

export class Stage {
  readonly object = new THREE.Group();
  /** [m] distance of the grid's lines. */
  spacing = 1;
  private readonly sky = new THREE.HemisphereLight(0xffffff, 0xb9b4ac, 1.8);
  private readonly key = new THREE.DirectionalLight(0xfff8ee, 1.6);
  private readonly rim = new THREE.DirectionalLight(0xdfe9ff, 0.7);
  private readonly shadow = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), new THREE.ShadowMaterial());
  private readonly grid = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), gridMaterial());
  private up = new THREE.Vector3(0, 0, 1);
  private radius = 1;
  private rest = 0; // height of the rest shape's lowest point along `up`
  private height = 0; // of the ground now

  constructor() {
    this.key.castShadow = true;
    this.key.shadow.mapSize.set(SHADOW_TEXELS, SHADOW_TEXELS);
    this.key.shadow.radius = 8;
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = -1;
    this.grid.renderOrder = -2;
    this.object.add(this.sky, this.key, this.key.target, this.rim, this.shadow, this.grid);
  }

  /** box: low xyz, high xyz of the rest shape [m]; up: axis; eye: the light comes from over the viewer's left shoulder. */
  fit(box: readonly number[], up: 0 | 1 | 2, eye: Vec3): void {
    this.up.set(0, 0, 0).setComponent(up, 1);
    const low = new THREE.Vector3().fromArray(box as number[]);
    const high = new THREE.Vector3().fromArray(box as number[], 3);
    const centre = low.clone().add(high).multiplyScalar(0.5);
    this.radius = Math.max(1e-9, 0.5 * low.distanceTo(high));
    this.rest = this.height = low.getComponent(up);
    this.spacing = niceStep(this.radius / 2.5);

    const view = new THREE.Vector3().fromArray(eye).sub(centre).projectOnPlane(this.up);
    if (view.length() < 1e-6 * this.radius) view.setComponent((up + 1) % 3, 1);
    view.normalize();
    const left = new THREE.Vector3().crossVectors(view, this.up);
    const from = (a: number, b: number, c: number) =>
      centre
        .clone()
        .addScaledVector(
          view.clone().multiplyScalar(a).addScaledVector(left, b).addScaledVector(this.up, c).normalize(),
          4 * this.radius,
        );
    this.sky.position.copy(this.up);
    this.key.position.copy(from(0.75, 0.8, 1.6));
    this.key.target.position.copy(centre);
    this.rim.position.copy(from(-1, -0.6, 0.5)).sub(centre);
    const { shadow } = this.key;
    const reach = 2.2 * this.radius; // the object may move out of its rest box
    Object.assign(shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach });
    shadow.camera.near = this.radius;
    shadow.camera.far = 8 * this.radius;
    shadow.camera.up.copy(this.up);
    shadow.camera.updateProjectionMatrix();
    shadow.bias = -0.0008;
    shadow.normalBias = 0.02 * this.radius;

    for (const plane of [this.shadow, this.grid]) {
      plane.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), this.up);
      plane.scale.setScalar(7 * this.radius);
      plane.position.copy(centre);
    }
    this.grid.material.uniforms["extent"].value = 7 * this.radius;
    this.grid.material.uniforms["spacing"].value = this.spacing;
    this.place();
  }

  /** The ground gives way to an object that sags below its rest shape, and comes back with a reset. */
  lower({ surface, low, extent, time }: Frame): void {
    const axis = this.up.x ? 0 : this.up.y ? 1 : 2;
    let least = 65535;
    for (let i = axis; i < surface.length; i += 3) if (surface[i] < least) least = surface[i];
    const lowest = low[axis] + (extent[axis] * least) / 65535;
    // What stands on the ground may tremble a little.
    const wanted = time === 0 || lowest > this.rest - 0.02 * this.radius ? this.rest : lowest - 0.02 * this.radius;
    this.height = time === 0 ? wanted : Math.min(this.height, wanted);
    this.place();
  }

  theme(dark: boolean): void {
    this.grid.material.uniforms["line"].value.set(dark ? 0x9fb0c8 : 0x3a4656);
    this.grid.material.uniforms["strength"].value = dark ? 0.22 : 0.2;
    this.shadow.material.opacity = dark ? 0.42 : 0.2;
  }

  private place(): void {
    for (const [plane, below] of [
      [this.shadow, 0],
      [this.grid, 0.001],
    ] as const) {
      const along = plane.position.dot(this.up);
      plane.position.addScaledVector(this.up, this.height - below * this.radius - along);
    }
  }
}

/** The largest of 1, 2, 5 times a power of ten that is not above `size`. */
export function niceStep(size: number): number {
  const power = 10 ** Math.floor(Math.log10(size));
  const digit = size / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

function gridMaterial(): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    uniforms: {
      line: { value: new THREE.Color() },
      strength: { value: 0.2 },
      extent: { value: 1 },
      spacing: { value: 1 },
    },
    vertexShader: /* glsl */ `
      uniform float extent;
      varying vec2 at;
      void main() {
        at = position.xy * extent;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: /* glsl */ `
      uniform vec3 line;
      uniform float strength, extent, spacing;
      varying vec2 at;
      float lines(float step) {
        vec2 cell = at / step;
        vec2 width = fwidth(cell);
        vec2 distance = abs(fract(cell - 0.5) - 0.5) / width;
        // Where cells become smaller than a pixel, lines would flicker: fade to nothing.
        vec2 visible = clamp(1.0 - 2.5 * width, 0.0, 1.0);
        vec2 cover = clamp(1.2 - distance, 0.0, 1.0) * visible;
        return max(cover.x, cover.y);
      }
      void main() {
        float fade = smoothstep(1.0, 0.15, length(at) / extent);
        float cover = max(0.45 * lines(spacing), lines(5.0 * spacing));
        gl_FragColor = linearToOutputTexel(vec4(line, strength * fade * cover));
      }`,
    transparent: true,
    depthWrite: false,
  });
}
