// The front as solid tets, coloured by level: cut away by whole tets, so that one looks at real elements inside, and
// pulled apart by an explosion. Each instance reads its four corners from the texture of the front's vertices.

import * as THREE from "three";

import type { Topology } from "../protocol";
import { LEVEL_COLOURS, MAX_LEVELS } from "./front";
import { FRONT_VERTEX } from "./front_vertices";
import type { FrontVertices } from "./front_vertices";
import { setTetInstances } from "./tet_instances";

const FACES = [1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1]; // corners of the four faces

export class FrontTets {
  readonly mesh: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.MeshStandardMaterial>;
  private readonly uniforms;

  constructor(vertices: FrontVertices) {
    this.uniforms = {
      frontPositions: vertices.uniform,
      levels: { value: LEVEL_COLOURS },
      explode: { value: 0 },
      middle: { value: new THREE.Vector3() },
      cut: { value: new THREE.Vector4(0, 0, 0, 1) }, // hidden where dot(cut.xyz, p) > cut.w
    };
    const material = new THREE.MeshStandardMaterial({
      flatShading: true,
      roughness: 0.7,
      metalness: 0,
      side: THREE.DoubleSide,
    });
    const depth = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking, side: THREE.DoubleSide });
    material.onBeforeCompile = (shader) => this.adapt(shader, true);
    depth.onBeforeCompile = (shader) => this.adapt(shader, false);
    this.mesh = new THREE.Mesh(new THREE.InstancedBufferGeometry(), material);
    this.mesh.customDepthMaterial = depth;
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
  }

  setTopology(topology: Topology): void {
    setTetInstances(this.mesh, topology, Float32Array.from(FACES.flatMap((corner, i) => [corner, i % 3, 0])));
  }

  /** Of tets that are drawn, without those cut away. */
  get count(): number {
    return this.mesh.geometry.instanceCount;
  }

  explode(amount: number, middle: THREE.Vector3): void {
    this.uniforms.explode.value = amount;
    this.uniforms.middle.value.copy(middle);
  }

  cut(plane: THREE.Plane | null): void {
    if (plane) this.uniforms.cut.value.set(-plane.normal.x, -plane.normal.y, -plane.normal.z, plane.constant);
    else this.uniforms.cut.value.set(0, 0, 0, 1);
  }

  private adapt(shader: THREE.WebGLProgramParametersWithUniforms, lit: boolean): void {
    Object.assign(shader.uniforms, this.uniforms);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\n${HEAD}`)
      .replace("#include <begin_vertex>", BODY);
    if (!lit) return;
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec3 tint;\nvarying vec3 within;")
      .replace(
        "#include <color_fragment>",
        `vec3 rim = within / fwidth(within);
        float edge = 1.0 - smoothstep(0.4, 1.4, min(rim.x, min(rim.y, rim.z)));
        diffuseColor.rgb *= tint * (1.0 - 0.6 * edge);`,
      );
  }
}

const HEAD = /* glsl */ `
  attribute ivec4 corners;
  attribute int level;
  uniform vec3 levels[${MAX_LEVELS}];
  uniform float explode;
  uniform vec3 middle;
  uniform vec4 cut;
  varying vec3 tint;
  varying vec3 within;
  ${FRONT_VERTEX}
`;

const BODY = /* glsl */ `
  int slot = int(position.x + 0.5);
  int vertex = slot == 0 ? corners.x : slot == 1 ? corners.y : slot == 2 ? corners.z : corners.w;
  vec3 centre = 0.25 * (frontVertex(corners.x) + frontVertex(corners.y) + frontVertex(corners.z) + frontVertex(corners.w));
  // A tet on the hidden side shrinks to a point: no fragment is left of it.
  float size = dot(cut.xyz, centre) > cut.w ? 0.0 : 1.0 - 0.15 * min(1.0, 4.0 * explode);
  vec3 transformed = middle + (centre - middle) * (1.0 + 0.9 * explode) + size * (frontVertex(vertex) - centre);
  within = vec3(position.y < 0.5, abs(position.y - 1.0) < 0.5, position.y > 1.5);
  tint = levels[min(level, ${MAX_LEVELS - 1})];
`;
