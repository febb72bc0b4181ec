// The front as a wireframe, coloured by level. Lines of several pixels that follow a moving front: the vertices'
// positions are a texture (front_vertices.ts), an edge is an instanced quad that reads its two ends from it.
// Edges behind the surface are drawn too, faintly, so that one sees into the object.

import * as THREE from "three";

import { levelColour } from "../palette";
import type { Topology } from "../protocol";
import { FRONT_VERTEX } from "./front_vertices";
import type { FrontVertices } from "./front_vertices";

const LINE_WIDTH = 1.4; // [CSS px]
export const MAX_LEVELS = 16;
export const LEVEL_COLOURS = Array.from({ length: MAX_LEVELS }, (_, level) => linearColour(level));

export class FrontLines {
  readonly object = new THREE.Group();
  private readonly shared = {
    frontPositions: { value: null as THREE.DataTexture | null },
    cut: { value: new THREE.Vector4(0, 0, 0, 1) }, // hidden where dot(cut.xyz, p) > cut.w
    viewport: { value: new THREE.Vector2(1, 1) }, // [device px]
    width: { value: LINE_WIDTH },
    contrast: { value: new THREE.Vector4() }, // colour to mix in, and how much
    levels: { value: LEVEL_COLOURS },
  };
  private readonly near;
  private readonly hidden;
  private geometry = new THREE.InstancedBufferGeometry();
  private readonly lines;

  constructor(vertices: FrontVertices) {
    this.shared.frontPositions = vertices.uniform;
    this.near = this.material(THREE.LessEqualDepth, 0.95);
    this.hidden = this.material(THREE.GreaterDepth, 0.13);
    this.lines = [this.hidden, this.near].map((material) => {
      const mesh = new THREE.Mesh(this.geometry, material);
      mesh.frustumCulled = false;
      mesh.renderOrder = material === this.near ? 2 : 1;
      this.object.add(mesh);
      return mesh;
    });
  }

  setTopology(topology: Topology): void {
    // three cannot grow an attribute: a new geometry for a new front, of exactly its size.
    this.geometry.dispose();
    this.geometry = new THREE.InstancedBufferGeometry();
    const corners = new Float32Array([0, -1, 0, 1, -1, 0, 0, 1, 0, 1, 1, 0]);
    this.geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
    this.geometry.setIndex([0, 1, 2, 2, 1, 3]);
    const ends = new THREE.InstancedBufferAttribute(new Int32Array(topology.edges), 2);
    ends.gpuType = THREE.IntType;
    this.geometry.setAttribute("ends", ends);
    const level = new THREE.InstancedBufferAttribute(new Int32Array(topology.edgeLevel), 1);
    level.gpuType = THREE.IntType;
    this.geometry.setAttribute("level", level);
    this.geometry.instanceCount = topology.edgeLevel.length;
    for (const mesh of this.lines) mesh.geometry = this.geometry;
  }

  cut(plane: THREE.Plane | null): void {
    if (plane) this.shared.cut.value.set(-plane.normal.x, -plane.normal.y, -plane.normal.z, plane.constant);
    else this.shared.cut.value.set(0, 0, 0, 1);
  }

  resize(width: number, height: number, pixelRatio: number): void {
    this.shared.viewport.value.set(width * pixelRatio, height * pixelRatio);
    this.shared.width.value = LINE_WIDTH * pixelRatio;
  }

  /** Lines stay readable on a surface of their own colour, and before the background. */
  theme(dark: boolean): void {
    if (dark) this.shared.contrast.value.set(1, 1, 1, 0.18);
    else this.shared.contrast.value.set(0, 0, 0, 0.5);
  }

  private material(depthFunc: THREE.DepthModes, opacity: number): THREE.ShaderMaterial {
    return new THREE.ShaderMaterial({
      uniforms: { ...this.shared, opacity: { value: opacity } },
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      glslVersion: THREE.GLSL3,
      transparent: true,
      depthWrite: false,
      depthFunc,
      side: THREE.DoubleSide,
    });
  }
}

function linearColour(level: number): THREE.Color {
  const [r, g, b] = levelColour(level);
  return new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace);
}

const VERTEX = /* glsl */ `
  in ivec2 ends;
  in int level;
  uniform vec2 viewport;
  uniform float width;
  uniform vec4 contrast;
  uniform vec3 levels[${MAX_LEVELS}];
  out vec3 tint;
  out float across;
  out float strength;

  uniform vec4 cut;
  ${FRONT_VERTEX}

  void main() {
    vec3 from = frontVertex(ends.x);
    vec3 to = frontVertex(ends.y);
    // What the cut hides of an edge is left away; all of it: a line without length.
    float da = dot(cut.xyz, from) - cut.w, db = dot(cut.xyz, to) - cut.w;
    if (da > 0.0 && db > 0.0) to = from;
    else if (da > 0.0) from = mix(from, to, da / (da - db));
    else if (db > 0.0) to = mix(to, from, db / (db - da));
    vec4 a = projectionMatrix * viewMatrix * vec4(from, 1.0);
    vec4 b = projectionMatrix * viewMatrix * vec4(to, 1.0);
    // An end behind the camera would turn the line around: cut it at the near plane.
    float na = a.z + a.w, nb = b.z + b.w;
    if (na < 0.0 && nb > 0.0) a = mix(a, b, na / (na - nb));
    if (nb < 0.0 && na > 0.0) b = mix(b, a, nb / (nb - na));
    vec2 stretch = 0.5 * (b.xy / b.w - a.xy / a.w) * viewport;  // [px]
    vec2 along = normalize(stretch + vec2(1e-6, 0.0));
    // Where edges become short, lines become faint: a fine front would be one blot.
    strength = clamp(length(stretch) / (20.0 * width), 0.12, 1.0);
    if (da > 0.0 && db > 0.0) strength = 0.0;
    vec4 here = position.x < 0.5 ? a : b;
    float radius = 0.5 * width + 0.5;  // half a pixel more for the soft rim
    here.xy += position.y * vec2(-along.y, along.x) * radius * 2.0 / viewport * here.w;
    gl_Position = here;
    across = position.y * radius;
    tint = mix(levels[min(level, ${MAX_LEVELS - 1})], contrast.rgb, contrast.a);
  }
`;

const FRAGMENT = /* glsl */ `
  uniform float opacity;
  uniform float width;
  in vec3 tint;
  in float across;
  in float strength;
  out vec4 colour;

  void main() {
    float cover = clamp(0.5 * width + 0.5 - abs(across), 0.0, 1.0);
    colour = linearToOutputTexel(vec4(tint, opacity * strength * cover));
  }
`;
