// The front as a wireframe, coloured by level. Lines of several pixels that follow a moving front: the vertices'
// positions are a texture (written once a frame), an edge is an instanced quad that reads its two ends from it.
// Edges behind the surface are drawn too, faintly, so that one sees into the object.

import * as THREE from "three";

import { levelColour } from "../palette";
import type { Topology } from "../protocol";

const WIDTH = 512; // texels in a row of the position texture
const LINE_WIDTH = 1.4; // [CSS px]
const MAX_LEVELS = 16;

export class FrontLines {
  readonly object = new THREE.Group();
  private readonly shared = {
    positions: { value: null as THREE.DataTexture | null },
    viewport: { value: new THREE.Vector2(1, 1) }, // [device px]
    width: { value: LINE_WIDTH },
    contrast: { value: new THREE.Vector4() }, // colour to mix in, and how much
    levels: { value: Array.from({ length: MAX_LEVELS }, (_, level) => linearColour(level)) },
  };
  private readonly near = this.material(THREE.LessEqualDepth, 0.95);
  private readonly hidden = this.material(THREE.GreaterDepth, 0.13);
  private geometry = new THREE.InstancedBufferGeometry();
  private readonly lines = [this.hidden, this.near].map((material) => {
    const mesh = new THREE.Mesh(this.geometry, material);
    mesh.frustumCulled = false;
    mesh.renderOrder = material === this.near ? 2 : 1;
    this.object.add(mesh);
    return mesh;
  });
  private texels = new Float32Array(0);

  /** [N][4], to be written by the caller, then `moved()`. */
  get positions(): Float32Array {
    return this.texels;
  }

  setTopology(topology: Topology): void {
    this.reserve(topology.frontVertices);
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

  moved(): void {
    if (this.shared.positions.value) this.shared.positions.value.needsUpdate = true;
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

  dispose(): void {
    this.geometry.dispose();
    this.shared.positions.value?.dispose();
    this.near.dispose();
    this.hidden.dispose();
  }

  /** The texture only grows, so that a front that breathes does not reallocate. */
  private reserve(vertices: number): void {
    const rows = Math.max(1, Math.ceil(vertices / WIDTH));
    if (this.texels.length >= 4 * WIDTH * rows) return;
    this.shared.positions.value?.dispose();
    this.texels = new Float32Array(4 * WIDTH * Math.ceil(1.25 * rows));
    const height = this.texels.length / (4 * WIDTH);
    const texture = new THREE.DataTexture(this.texels, WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
    texture.needsUpdate = true;
    this.shared.positions.value = texture;
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
  uniform highp sampler2D positions;
  uniform vec2 viewport;
  uniform float width;
  uniform vec4 contrast;
  uniform vec3 levels[${MAX_LEVELS}];
  out vec3 tint;
  out float across;
  out float strength;

  vec4 clip(int vertex) {
    vec3 p = texelFetch(positions, ivec2(vertex % ${WIDTH}, vertex / ${WIDTH}), 0).xyz;
    return projectionMatrix * viewMatrix * vec4(p, 1.0);
  }

  void main() {
    vec4 a = clip(ends.x);
    vec4 b = clip(ends.y);
    // An end behind the camera would turn the line around: cut it at the near plane.
    float na = a.z + a.w, nb = b.z + b.w;
    if (na < 0.0 && nb > 0.0) a = mix(a, b, na / (na - nb));
    if (nb < 0.0 && na > 0.0) b = mix(b, a, nb / (nb - na));
    vec2 stretch = 0.5 * (b.xy / b.w - a.xy / a.w) * viewport;  // [px]
    vec2 along = normalize(stretch + vec2(1e-6, 0.0));
    // Where edges become short, lines become faint: a fine front would be one blot.
    strength = clamp(length(stretch) / (20.0 * width), 0.12, 1.0);
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
