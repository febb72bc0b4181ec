// The present as a pale, transparent shape over a moment of the past.

import * as THREE from "three";

import { unpack } from "../protocol";
import type { Frame, Model } from "../protocol";

export class Ghost {
  readonly object: THREE.Mesh<THREE.BufferGeometry, THREE.MeshBasicMaterial>;

  constructor() {
    const material = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.16, depthWrite: false });
    this.object = new THREE.Mesh(new THREE.BufferGeometry(), material);
    this.object.frustumCulled = false;
    this.object.renderOrder = 3;
    this.object.visible = false;
  }

  theme(dark: boolean): void {
    this.object.material.color.set(dark ? 0xdbe7ff : 0x1f3a66);
  }

  setModel(model: Model): void {
    this.object.geometry.dispose();
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(model.triangles, 1));
    const positions = new THREE.BufferAttribute(new Float32Array(3 * model.young.length), 3);
    geometry.setAttribute("position", positions.setUsage(THREE.DynamicDrawUsage));
    this.object.geometry = geometry;
    this.object.visible = false;
  }

  move({ surface, low, extent }: Frame): void {
    const attribute = this.object.geometry.getAttribute("position") as THREE.BufferAttribute;
    unpack(surface, low, extent, attribute.array as Float32Array);
    attribute.needsUpdate = true;
  }
}
