// A plane that cuts the object open. Where it cuts through the smooth surface, the cut face is closed by a cap: the stencil
// counts surfaces in front of the plane, and the cap is drawn where more were entered than left. On it lie the front's tets.

import * as THREE from "three";

import type { Topology } from "../protocol";
import type { Cut } from "../store";
import type { FrontVertices } from "./front_vertices";
import { SectionTets } from "./section_tets";
import type { SurfaceMesh } from "./surface";

export class Section {
  readonly object = new THREE.Group();
  /** What lies behind it, against its normal, is hidden. Null: nothing is. */
  plane: THREE.Plane | null = null;
  private readonly clip = new THREE.Plane();
  private readonly cap: THREE.Mesh<THREE.PlaneGeometry, THREE.MeshStandardMaterial>;
  private counters: THREE.Mesh[] = [];

  private readonly tets: SectionTets;

  constructor(vertices: FrontVertices) {
    this.tets = new SectionTets(vertices);
    const material = new THREE.MeshStandardMaterial({
      roughness: 0.9,
      metalness: 0,
      side: THREE.DoubleSide,
      stencilWrite: true,
      stencilRef: 0,
      stencilFunc: THREE.NotEqualStencilFunc,
    });
    this.cap = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material);
    this.cap.renderOrder = 0.5; // after the surface and what counts it
    this.object.add(this.cap, this.tets.mesh);
    this.object.visible = false;
  }

  theme(dark: boolean): void {
    this.cap.material.color.set(dark ? 0x8d8a84 : 0xa8a49b);
  }

  /** Shares the surface's buffers; to be called for each new surface. */
  attach(surface: SurfaceMesh): void {
    for (const mesh of this.counters) {
      mesh.removeFromParent();
      (mesh.material as THREE.Material).dispose();
    }
    this.counters = [
      counter(surface.mesh.geometry, THREE.BackSide, THREE.IncrementWrapStencilOp, this.clip),
      counter(surface.mesh.geometry, THREE.FrontSide, THREE.DecrementWrapStencilOp, this.clip),
    ];
    this.object.add(...this.counters);
  }

  /** Whether the front's tets are drawn on the cut, and with them their positions are wanted. */
  get showsTets(): boolean {
    return this.object.visible && this.tets.mesh.visible;
  }

  /** The front's tets on the cut, by level; null: plain. */
  setTets(topology: Topology | null): void {
    this.tets.mesh.visible = topology !== null;
    if (topology) this.tets.setTopology(topology);
  }

  /** box: low xyz, high xyz of the rest shape [m]. Returns the planes that the surface is clipped by. */
  set(cut: Cut | null, box: readonly number[], solid: boolean): THREE.Plane[] {
    this.plane = cut ? this.clip : null;
    this.object.visible = cut !== null && solid;
    if (!cut) return [];
    const { axis, at, flip } = cut;
    const place = box[axis] + at * (box[3 + axis] - box[axis]);
    const normal = new THREE.Vector3().setComponent(axis, flip ? 1 : -1);
    this.clip.set(normal, flip ? -place : place);
    this.tets.cut(this.clip);
    const size = Math.hypot(box[3] - box[0], box[4] - box[1], box[5] - box[2]);
    this.cap.scale.setScalar(4 * size);
    this.cap.position.set(...([0, 1, 2].map((i) => 0.5 * (box[i] + box[3 + i])) as [number, number, number]));
    this.cap.position.setComponent(axis, place);
    this.cap.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal.clone().negate());
    return [this.clip];
  }
}

function counter(
  geometry: THREE.BufferGeometry,
  side: THREE.Side,
  operation: THREE.StencilOp,
  plane: THREE.Plane,
): THREE.Mesh {
  const material = new THREE.MeshBasicMaterial({
    side,
    depthWrite: false,
    depthTest: false,
    colorWrite: false,
    clippingPlanes: [plane],
    stencilWrite: true,
    stencilFunc: THREE.AlwaysStencilFunc,
    stencilFail: operation,
    stencilZFail: operation,
    stencilZPass: operation,
  });
  const mesh = new THREE.Mesh(geometry, material);
  mesh.frustumCulled = false;
  mesh.renderOrder = 0.1;
  return mesh;
}
