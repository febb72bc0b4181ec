// The smooth surface: buffers are made once for a model; each frame overwrites positions and normals, a change of the
// colouring overwrites the colours.

import * as THREE from "three";

import { levelColour, mapColour } from "../palette";
import type { Rgb } from "../palette";
import type { Scale } from "../scale";
import type { FrameValues, Model } from "../protocol";
import { computeNormals } from "./normals";

export class SurfaceMesh {
  readonly mesh: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
  readonly positions: Float32Array; // [S][3]
  readonly triangles: Uint32Array; // [F][3]
  private readonly normals: Float32Array;
  private readonly colours: Uint8Array; // [S][3] sRGB
  private readonly geometry = new THREE.BufferGeometry();

  constructor(private readonly model: Model) {
    const size = 3 * model.young.length;
    this.triangles = model.triangles;
    this.positions = new Float32Array(size);
    this.normals = new Float32Array(size);
    this.colours = new Uint8Array(size);
    this.geometry.setAttribute("position", dynamic(new THREE.BufferAttribute(this.positions, 3)));
    this.geometry.setAttribute("normal", dynamic(new THREE.BufferAttribute(this.normals, 3)));
    this.geometry.setAttribute("color", dynamic(new THREE.BufferAttribute(this.colours, 3, true)));
    this.geometry.setIndex(new THREE.BufferAttribute(model.triangles, 1));
    const material = new THREE.MeshStandardMaterial({
      vertexColors: true,
      roughness: 0.58,
      metalness: 0,
      side: THREE.DoubleSide,
      // Lines that lie on the surface win over it.
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    decodeSrgbColours(material);
    this.mesh = new THREE.Mesh(this.geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.castShadow = this.mesh.receiveShadow = true;
  }

  /** After `positions` have been written. */
  moved(): void {
    computeNormals(this.positions, this.triangles, this.normals);
    this.geometry.attributes["position"].needsUpdate = true;
    this.geometry.attributes["normal"].needsUpdate = true;
  }

  /** By level of refinement, by the model's moduli, or by the values of a frame. */
  colour(by: { levels: Uint8Array } | { scale: Scale; values: FrameValues | null }): void {
    if ("levels" in by) {
      const table = bytes(256, (level) => levelColour(level));
      this.paint(table, (vertex) => by.levels[vertex]);
      return;
    }
    const { scale, values } = by;
    const table = bytes(256, (i) => mapColour(i / 255, scale.map));
    if (values) {
      const [low, high] = scale.range;
      const factor = high > low ? (255 * values.high) / (65535 * (high - low)) : 0;
      this.paint(table, (vertex) => Math.min(255, factor * values.packed[vertex] + 0.5) | 0);
    } else {
      this.paint(table, (vertex) => Math.round(255 * scale.position(this.model.young[vertex])));
    }
  }

  /** What lies behind one of these planes is not drawn and casts no shadow. */
  clip(planes: THREE.Plane[]): void {
    const { material } = this.mesh;
    if ((material.clippingPlanes?.length ?? 0) !== planes.length) material.needsUpdate = true;
    material.clippingPlanes = planes;
    material.clipShadows = true;
  }

  dispose(): void {
    this.geometry.dispose();
    this.mesh.material.dispose();
  }

  private paint(table: Uint8Array, entry: (vertex: number) => number): void {
    for (let vertex = 0, i = 0; i < this.colours.length; ++vertex, i += 3) {
      const from = 3 * entry(vertex);
      this.colours[i] = table[from];
      this.colours[i + 1] = table[from + 1];
      this.colours[i + 2] = table[from + 2];
    }
    this.geometry.attributes["color"].needsUpdate = true;
  }
}

const bytes = (length: number, colour: (i: number) => Rgb): Uint8Array =>
  Uint8Array.from(Array.from({ length }, (_, i) => colour(i)).flat(), (x) => 255 * x + 0.5);

const dynamic = (attribute: THREE.BufferAttribute): THREE.BufferAttribute => attribute.setUsage(THREE.DynamicDrawUsage);

/** Colours stay sRGB bytes up to the fragment, so that they blend in the space in which the maps are defined. */
function decodeSrgbColours(material: THREE.MeshStandardMaterial): void {
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace(
      "#include <color_fragment>",
      "diffuseColor.rgb *= mix(vColor / 12.92, pow((vColor + 0.055) / 1.055, vec3(2.4)), step(0.04045, vColor));",
    );
  };
}
