// The smooth surface: buffers are made once for a model; each frame overwrites positions and normals, a change of the
// colouring overwrites the colours.

import * as THREE from "three";

import { levelColour, mapColour, stiffnessPosition } from "../palette";
import type { Rgb } from "../palette";
import type { Colouring, Model } from "../protocol";
import { computeNormals } from "./normals";

export class SurfaceMesh {
  readonly mesh: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
  readonly positions: Float32Array; // [S][3]
  readonly triangles: Uint32Array; // [F][3]
  private readonly normals: Float32Array;
  private readonly colours: Uint8Array; // [S][3] sRGB
  private readonly geometry = new THREE.BufferGeometry();

  constructor(
    private readonly model: Model,
    private readonly youngRange: readonly [number, number],
  ) {
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

  colour(colouring: Colouring, surfaceLevel: Uint8Array): void {
    const { young } = this.model;
    if (colouring === "level") {
      const table = Array.from({ length: 256 }, (_, level) => levelColour(level));
      this.paint((vertex) => table[surfaceLevel[vertex]]);
    } else {
      const table = Array.from({ length: 256 }, (_, i) => mapColour(i / 255));
      this.paint((vertex) => table[Math.round(255 * stiffnessPosition(young[vertex], this.youngRange))]);
    }
  }

  dispose(): void {
    this.geometry.dispose();
    this.mesh.material.dispose();
  }

  private paint(colour: (vertex: number) => Rgb): void {
    for (let vertex = 0, i = 0; i < this.colours.length; ++vertex, i += 3) {
      const [r, g, b] = colour(vertex);
      this.colours[i] = 255 * r + 0.5;
      this.colours[i + 1] = 255 * g + 0.5;
      this.colours[i + 2] = 255 * b + 0.5;
    }
    this.geometry.attributes["color"].needsUpdate = true;
  }
}

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
