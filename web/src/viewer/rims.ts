// Rims of regions in the picture: of each part of other stiffness, with its factor beside it, and of what a key or a tap
// would mean now. A dark or bright core in a rim of the other kind, so that a line is seen on every colour.

import * as THREE from "three";

import { significant } from "../format";
import type { StiffnessPart, SurfacePlace } from "../messages";
import { effective, keyOf } from "../parts";
import type { Place } from "../parts";
import type { CameraRig } from "./camera";
import { surfacePoint } from "./pick";
import { findRim, placeRim } from "./region";
import type { Rim } from "./region";
import type { SurfaceMesh } from "./surface";

export interface Scenery {
  parts: readonly StiffnessPart[];
  preview: Place | null;
  surface: SurfaceMesh;
  atRest: boolean; // the shape is that at rest
  rig: CameraRig;
  width: number; // [CSS px]
  height: number;
  hides: ((point: THREE.Vector3) => boolean) | null; // null: nothing is cut away
  apart: boolean; // the tets are: there is no surface for rims to lie on
}

const WIDTH = 6; // [CSS px] with the rim
const STIFFER = new THREE.Color("#8f1019");
const SOFTER = new THREE.Color("#f6b83c");
const PREVIEW = new THREE.Color("#1f5fbf");

export class Rims {
  readonly object: THREE.Mesh<THREE.InstancedBufferGeometry, THREE.ShaderMaterial>;
  private readonly viewport = new THREE.Vector2(1, 1);
  private readonly known = new Map<string, { rim: Rim; atRest: boolean }>();
  private surface: SurfaceMesh | null = null; // whose rims are known
  private ends = new Float32Array(0); // [n][2][3]
  private colours = new Float32Array(0); // [n][3] linear
  private readonly tags: HTMLElement[] = [];

  constructor(private readonly labels: HTMLElement) {
    this.object = new THREE.Mesh(new THREE.InstancedBufferGeometry(), lineMaterial(this.viewport));
    this.object.frustumCulled = false;
    this.object.renderOrder = 3;
  }

  update(scenery: Scenery): void {
    const { parts, preview, surface, width, height } = scenery;
    if (surface !== this.surface) this.known.clear();
    this.surface = surface;
    const fits = ({ triangle }: SurfacePlace) => 3 * triangle < surface.triangles.length;
    const shown = effective(parts).filter(fits);
    const regions = shown.map((part) => ({
      rim: this.rimOf(part, scenery),
      colour: part.value > 1 ? STIFFER : SOFTER,
    }));
    const keys = new Set(shown.map(keyOf));
    if (preview && fits(preview)) {
      regions.push({ rim: this.rimOf(preview, scenery), colour: PREVIEW });
      keys.add(keyOf(preview));
    }
    for (const key of this.known.keys()) if (!keys.has(key)) this.known.delete(key);
    this.viewport.set(width, height);
    this.draw(scenery.apart ? [] : regions, scenery);
    this.tag(shown, scenery);
  }

  /** Found in the shape at rest when that is seen; until then in the one that is there. */
  private rimOf(part: Place, { surface, atRest }: Scenery): Rim {
    const key = keyOf(part);
    const known = this.known.get(key);
    if (known && (known.atRest || !atRest)) return known.rim;
    const { positions, triangles } = surface;
    const rim = findRim(
      positions,
      triangles,
      surfacePoint(positions, triangles, part.triangle, part.barycentric),
      part.radius,
    );
    this.known.set(key, { rim, atRest });
    return rim;
  }

  private draw(
    regions: readonly { rim: Rim; colour: THREE.Color }[],
    { surface: { positions }, hides }: Scenery,
  ): void {
    const count = regions.reduce((sum, { rim }) => sum + rim.at.length / 2, 0);
    this.object.visible = count > 0;
    if (count === 0) return;
    if (6 * count > this.ends.length) this.reserve(2 * count);
    let offset = 0;
    for (const { rim, colour } of regions) {
      const from = offset / 6;
      const end = placeRim(rim, positions, this.ends, offset);
      offset = hides ? this.closeUp(offset, end, hides) : end;
      for (let i = from; i < offset / 6; ++i) colour.toArray(this.colours, 3 * i);
    }
    const { geometry } = this.object;
    geometry.instanceCount = offset / 6;
    (geometry.attributes["from"] as THREE.InterleavedBufferAttribute).data.needsUpdate = true;
    geometry.attributes["tint"].needsUpdate = true;
  }

  /** Moves the segments that are not hidden together; returns where they end. */
  private closeUp(begin: number, end: number, hides: (point: THREE.Vector3) => boolean): number {
    const point = new THREE.Vector3();
    let to = begin;
    for (let from = begin; from < end; from += 6) {
      if (hides(point.fromArray(this.ends, from))) continue;
      this.ends.copyWithin(to, from, from + 6);
      to += 6;
    }
    return to;
  }

  /** three cannot grow an attribute: a new geometry. */
  private reserve(segments: number): void {
    this.ends = new Float32Array(6 * segments);
    this.colours = new Float32Array(3 * segments);
    this.object.geometry.dispose();
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute(
      "position",
      new THREE.BufferAttribute(Float32Array.of(0, -1, 0, 1, -1, 0, 0, 1, 0, 1, 1, 0), 3),
    );
    geometry.setIndex([0, 1, 2, 2, 1, 3]);
    const ends = new THREE.InstancedInterleavedBuffer(this.ends, 6).setUsage(THREE.DynamicDrawUsage);
    geometry.setAttribute("from", new THREE.InterleavedBufferAttribute(ends, 3, 0));
    geometry.setAttribute("to", new THREE.InterleavedBufferAttribute(ends, 3, 3));
    geometry.setAttribute("tint", new THREE.InstancedBufferAttribute(this.colours, 3));
    this.object.geometry = geometry;
  }

  /** Beside the middle of each part that faces the viewer: its number in the panel and its factor. */
  private tag(parts: readonly StiffnessPart[], { surface, rig, height, hides, apart }: Scenery): void {
    while (this.tags.length < parts.length) {
      const tag = document.createElement("output");
      tag.className = "part";
      this.labels.append(tag);
      this.tags.push(tag);
    }
    this.tags.forEach((tag, i) => {
      const part = parts[i] as StiffnessPart | undefined;
      tag.hidden = true;
      if (!part) return;
      const { positions, triangles } = surface;
      const [a, b, c] = [0, 1, 2].map((k) =>
        new THREE.Vector3().fromArray(positions, 3 * triangles[3 * part.triangle + k]),
      );
      const point = new THREE.Vector3(...surfacePoint(positions, triangles, part.triangle, part.barycentric));
      const outward = b.sub(a).cross(c.sub(a)).normalize();
      tag.hidden =
        apart || outward.dot(rig.camera.position.clone().sub(point)) <= 0 || (hides !== null && hides(point));
      tag.textContent = partLabel(part, i);
      const [x, y] = rig.project(point);
      // Above the rim, as long as it is small: how far a disc that faces outward reaches towards the picture's top.
      const up = new THREE.Vector3().setFromMatrixColumn(rig.camera.matrixWorld, 1).dot(outward);
      const reach = (part.radius * Math.sqrt(Math.max(0, 1 - up * up))) / rig.metresPerPixel(point, height);
      const above = Math.min(40, reach) + 6;
      tag.style.transform = `translate(${x}px, ${y - above}px) translate(-50%, -100%)`;
    });
  }
}

/** As the panel counts them. */
export const partLabel = ({ value }: Pick<StiffnessPart, "value">, index: number): string =>
  `${index + 1}: ×${significant(value)}`;

function lineMaterial(viewport: THREE.Vector2): THREE.ShaderMaterial {
  return new THREE.ShaderMaterial({
    uniforms: { viewport: { value: viewport }, width: { value: WIDTH } },
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    glslVersion: THREE.GLSL3,
    transparent: true,
    depthWrite: false,
    side: THREE.DoubleSide,
  });
}

const VERTEX = /* glsl */ `
  in vec3 from, to, tint;
  uniform vec2 viewport;
  uniform float width;
  out vec3 core;
  out float across;

  void main() {
    vec4 a = projectionMatrix * viewMatrix * vec4(from, 1.0);
    vec4 b = projectionMatrix * viewMatrix * vec4(to, 1.0);
    // An end behind the camera would turn the line around: cut it at the near plane.
    float na = a.z + a.w, nb = b.z + b.w;
    if (na < 0.0 && nb > 0.0) a = mix(a, b, na / (na - nb));
    if (nb < 0.0 && na > 0.0) b = mix(b, a, nb / (nb - na));
    vec2 along = normalize(0.5 * (b.xy / b.w - a.xy / a.w) * viewport + vec2(1e-6, 0.0));
    vec4 here = position.x < 0.5 ? a : b;
    // A little longer, so that segments meet without gaps.
    here.xy += (position.y * vec2(-along.y, along.x) * width + (2.0 * position.x - 1.0) * along) / viewport * here.w;
    here.z -= 0.0006 * here.w;  // in front of the surface it lies on
    gl_Position = here;
    across = position.y * 0.5 * width;
    core = tint;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform float width;
  in vec3 core;
  in float across;
  out vec4 colour;

  void main() {
    float away = abs(across);
    float bright = step(0.2, dot(core, vec3(0.21, 0.72, 0.07)));
    vec3 rim = bright > 0.5 ? vec3(0.02) : vec3(1.0);
    float inner = clamp(0.25 * width + 0.5 - away, 0.0, 1.0);
    float cover = clamp(0.5 * width - away, 0.0, 1.0);
    colour = linearToOutputTexel(vec4(mix(rim, core, inner), cover));
  }
`;
