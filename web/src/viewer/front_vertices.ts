// Positions of the front's vertices as a texture, written once a frame; lines and tets read their corners from it.

import * as THREE from "three";

const WIDTH = 512; // texels in a row

export class FrontVertices {
  /** The texture, as a uniform that shaders share. */
  readonly uniform = { value: null as THREE.DataTexture | null };
  /** [N][4], to be written by the caller, then `moved()`. */
  positions = new Float32Array(0);

  /** The texture only grows, so that a front that breathes does not reallocate. */
  reserve(vertices: number): void {
    const rows = Math.max(1, Math.ceil(vertices / WIDTH));
    if (this.positions.length >= 4 * WIDTH * rows) return;
    this.dispose();
    const height = Math.ceil(1.25 * rows);
    this.positions = new Float32Array(4 * WIDTH * height);
    this.uniform.value = new THREE.DataTexture(this.positions, WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
    this.moved();
  }

  moved(): void {
    if (this.uniform.value) this.uniform.value.needsUpdate = true;
  }

  dispose(): void {
    this.uniform.value?.dispose();
    this.uniform.value = null;
    this.positions = new Float32Array(0);
  }
}

/** GLSL: vec3 frontVertex(int vertex). */
export const FRONT_VERTEX = /* glsl */ `
  uniform highp sampler2D frontPositions;
  vec3 frontVertex(int vertex) {
    return texelFetch(frontPositions, ivec2(vertex % ${WIDTH}, vertex / ${WIDTH}), 0).xyz;
  }
`;
