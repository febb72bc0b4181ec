// Pulls made visible: a dot where the surface is held, a rubber band to the hand, an arrow head there, and the force in
// newtons. Sizes are in pixels, so that a pull is seen from any distance; nothing hides it.

import * as THREE from "three";

import { quantity } from "../format";
import { FORCE, PULL } from "../palette";
import type { CameraRig } from "./camera";

export interface Band {
  from: readonly [number, number, number]; // [m] grabbed point
  to: readonly [number, number, number]; // [m] the hand
  force: number | null; // [N], null: not known yet, or none
  kind: BandKind;
}

export type BandKind = "own" | "other" | "force" | "selected" | "pin";

const COLOURS: Record<BandKind, string> = {
  own: PULL,
  other: "#8a94a6", // pulls of other viewers
  force: FORCE,
  selected: "#b45309",
  pin: "#334155",
};

export class Bands {
  readonly object = new THREE.Group();
  private readonly pool: {
    root: THREE.Group;
    dot: THREE.Mesh;
    line: THREE.Mesh;
    head: THREE.Mesh;
    label: HTMLElement;
  }[] = [];
  private readonly dot = new THREE.SphereGeometry(1, 16, 12);
  private readonly line = new THREE.CylinderGeometry(1, 1, 1, 12, 1, true).translate(0, 0.5, 0);
  private readonly head = new THREE.ConeGeometry(1, 1, 20).translate(0, 0.5, 0);
  private readonly materials = Object.fromEntries(
    Object.entries(COLOURS).map(([kind, colour]) => [kind, flat(colour)]),
  ) as Record<BandKind, THREE.MeshBasicMaterial>;

  constructor(private readonly labels: HTMLElement) {}

  update(bands: readonly Band[], rig: CameraRig, width: number, height: number): void {
    while (this.pool.length < bands.length) this.pool.push(this.create());
    this.pool.forEach(({ root, dot, line, head, label }, i) => {
      const band = bands[i] as Band | undefined;
      root.visible = band !== undefined;
      label.hidden = band === undefined || band.force === null;
      if (!band) return;
      const material = this.materials[band.kind];
      label.dataset["kind"] = band.kind;
      dot.material = line.material = head.material = material;
      const from = new THREE.Vector3(...band.from);
      const to = new THREE.Vector3(...band.to);
      const pixel = rig.metresPerPixel(to, height);
      const length = from.distanceTo(to);
      const tip = Math.min(12 * pixel, length);
      const along = to.clone().sub(from);
      const turn = new THREE.Quaternion().setFromUnitVectors(
        new THREE.Vector3(0, 1, 0),
        length > 0 ? along.clone().divideScalar(length) : new THREE.Vector3(0, 1, 0),
      );
      dot.position.copy(from);
      dot.scale.setScalar((band.kind === "pin" ? 6 : 4.5) * rig.metresPerPixel(from, height));
      line.position.copy(from);
      line.quaternion.copy(turn);
      line.scale.set(1.5 * pixel, Math.max(1e-12, length - tip), 1.5 * pixel);
      line.visible = length > 0;
      head.visible = length > 2 * pixel;
      head.quaternion.copy(turn);
      head.position.copy(to).addScaledVector(along, length > 0 ? -tip / length : 0);
      head.scale.set(5 * pixel, Math.max(1e-12, tip), 5 * pixel);

      if (band.force === null) return;
      label.textContent = quantity(band.force, "N");
      const at = to.project(rig.camera);
      label.style.transform = `translate(${((at.x + 1) / 2) * width + 12}px, ${((1 - at.y) / 2) * height - 26}px)`;
    });
  }

  private create(): (typeof this.pool)[number] {
    const root = new THREE.Group();
    const make = (geometry: THREE.BufferGeometry) => {
      const mesh = new THREE.Mesh(geometry, this.materials.own);
      mesh.renderOrder = 10;
      mesh.frustumCulled = false;
      root.add(mesh);
      return mesh;
    };
    const label = document.createElement("output");
    label.className = "force";
    this.labels.append(label);
    this.object.add(root);
    return { root, dot: make(this.dot), line: make(this.line), head: make(this.head), label };
  }
}

const flat = (colour: string): THREE.MeshBasicMaterial =>
  new THREE.MeshBasicMaterial({ color: colour, depthTest: false, transparent: true });
