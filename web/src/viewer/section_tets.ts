// What the cut shows of the front: where the plane meets each tet, a triangle or a quadrilateral coloured by level. All
// of it in the vertex shader: an instance is a tet, which finds its own polygon.

import * as THREE from "three";

import type { Topology } from "../protocol";
import { LEVEL_COLOURS, MAX_LEVELS } from "./front";
import { FRONT_VERTEX } from "./front_vertices";
import type { FrontVertices } from "./front_vertices";
import { setTetInstances } from "./tet_instances";

export class SectionTets {
  readonly mesh: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.MeshStandardMaterial>;
  private readonly uniforms;

  constructor(vertices: FrontVertices) {
    this.uniforms = {
      frontPositions: vertices.uniform,
      levels: { value: LEVEL_COLOURS },
      cut: { value: new THREE.Vector4(0, 0, 0, 1) }, // hidden where dot(cut.xyz, p) > cut.w
    };
    const material = new THREE.MeshStandardMaterial({
      flatShading: true, // polygons turn either way; their front face must not decide about light
      roughness: 0.9,
      metalness: 0,
      side: THREE.DoubleSide,
      // In the plane of the cap, which fills what straight tets leave between themselves and the surface.
      polygonOffset: true,
      polygonOffsetFactor: -1,
      polygonOffsetUnits: -1,
      stencilWrite: true,
      stencilRef: 0,
      stencilFunc: THREE.NotEqualStencilFunc,
    });
    material.onBeforeCompile = (shader) => this.adapt(shader);
    this.mesh = new THREE.Mesh(new THREE.InstancedBufferGeometry(), material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = 0.6; // after the cap
    this.mesh.visible = false;
  }

  setTopology(topology: Topology): void {
    const slots = Float32Array.of(0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0);
    setTetInstances(this.mesh, topology, slots, [0, 1, 2, 0, 2, 3]);
  }

  cut(plane: THREE.Plane): void {
    this.uniforms.cut.value.set(-plane.normal.x, -plane.normal.y, -plane.normal.z, plane.constant);
  }

  private adapt(shader: THREE.WebGLProgramParametersWithUniforms): void {
    Object.assign(shader.uniforms, this.uniforms);
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\n${HEAD}`)
      .replace("#include <begin_vertex>", BODY);
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", "#include <common>\nvarying vec3 tint;\nvarying vec2 within;")
      .replace(
        "#include <color_fragment>",
        `vec2 rim = min(within, 1.0 - within) / fwidth(within);
        float edge = 1.0 - smoothstep(0.3, 1.3, min(rim.x, rim.y));
        diffuseColor.rgb *= tint * (1.0 - 0.45 * edge);`,
      );
  }
}

const HEAD = /* glsl */ `
  attribute ivec4 corners;
  attribute int level;
  uniform vec3 levels[${MAX_LEVELS}];
  uniform vec4 cut;
  varying vec3 tint;
  varying vec2 within;
  ${FRONT_VERTEX}
  vec3 crossing(vec4 a, vec4 b) { return mix(a.xyz, b.xyz, a.w / (a.w - b.w)); } // w: height over the plane
`;

const BODY = /* glsl */ `
  vec4 above[4], below[4];
  int up = 0, down = 0;
  for (int i = 0; i < 4; ++i) {
    vec3 p = frontVertex(corners[i]);
    vec4 corner = vec4(p, dot(cut.xyz, p) - cut.w);
    if (corner.w > 0.0) above[up++] = corner;
    else below[down++] = corner;
  }
  int slot = int(position.x + 0.5);
  vec3 transformed = vec3(0.0); // all corners in one point: nothing to be seen
  if (up == 2) {
    transformed = crossing(above[slot / 2], below[slot == 1 || slot == 2 ? 1 : 0]);
  } else if (up == 1 || up == 3) {
    // A triangle is a quadrilateral with a corner amid a side, so that all its sides are sides of that.
    vec4 tip = up == 1 ? above[0] : below[0];
    vec3 p[3];
    for (int i = 0; i < 3; ++i) p[i] = crossing(tip, up == 1 ? below[i] : above[i]);
    transformed = slot == 0 ? 0.5 * (p[0] + p[2]) : p[slot - 1];
  }
  within = vec2(slot == 1 || slot == 2, slot >= 2);
  tint = levels[min(level, ${MAX_LEVELS - 1})];
`;
