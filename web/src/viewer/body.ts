// The object in the picture: smooth surface or solid tets, the front's wireframe, the cut, and a ghost of the present
// while one looks at the past. Knows no renderer and no events.

import * as THREE from "three";

import type { SurfacePlace, Vec3 } from "../messages";
import type { Frame, Model, Topology } from "../protocol";
import { isField } from "../scale";
import { scaleOf } from "../store";
import type { State } from "../store";
import { FrontLines } from "./front";
import { FrontTets } from "./front_tets";
import { FrontVertices } from "./front_vertices";
import { Ghost } from "./ghost";
import type { Motion } from "./motion";
import { surfacePoint } from "./pick";
import { Section } from "./section";
import { SurfaceMesh } from "./surface";

export class Body {
  readonly object = new THREE.Group();
  readonly lines: FrontLines;
  surface: SurfaceMesh | null = null;
  private readonly vertices = new FrontVertices();
  private readonly tets: FrontTets;
  private readonly section: Section;
  private readonly ghost = new Ghost();
  private topology: Topology | null = null;
  private sectionTopology: Topology | null = null; // whose tets the cut shows
  private hasPositions = false;

  constructor() {
    this.lines = new FrontLines(this.vertices);
    this.tets = new FrontTets(this.vertices);
    this.section = new Section(this.vertices);
    this.object.add(this.lines.object, this.tets.mesh, this.section.object, this.ghost.object);
  }

  theme(dark: boolean): void {
    this.lines.theme(dark);
    this.section.theme(dark);
    this.ghost.theme(dark);
  }

  setModel(model: Model): void {
    this.surface?.mesh.removeFromParent();
    this.surface?.dispose();
    this.surface = new SurfaceMesh(model);
    this.section.attach(this.surface);
    this.ghost.setModel(model);
    this.object.add(this.surface.mesh);
    this.topology = null;
    this.hasPositions = false;
    this.surface.mesh.visible = this.lines.object.visible = this.tets.mesh.visible = false;
  }

  get epoch(): number | null {
    return this.topology?.epoch ?? null;
  }

  setTopology(topology: Topology, state: Readonly<State>): void {
    this.topology = topology;
    this.vertices.reserve(topology.frontVertices);
    this.lines.setTopology(topology);
    if (state.shape === "tets") this.tets.setTopology(topology);
    this.showSectionTets(state);
  }

  /** What is visible, cut and exploded; to be called when any of it changes and with the first frame. */
  show(state: Readonly<State>, hasPositions = this.hasPositions): void {
    this.hasPositions = hasPositions;
    if (!this.surface || !state.hello) return;
    const tets = state.shape === "tets";
    if (tets && !this.tets.mesh.visible && this.topology) this.tets.setTopology(this.topology);
    const box = state.hello.rest_box;
    this.surface.clip(this.section.set(state.cut, box, hasPositions && !tets));
    this.showSectionTets(state);
    this.lines.cut(this.section.plane);
    this.tets.cut(this.section.plane);
    this.tets.explode(
      state.explode,
      new THREE.Vector3(...([0, 1, 2].map((i) => 0.5 * (box[i] + box[3 + i])) as [number, number, number])),
    );
    this.surface.mesh.visible = hasPositions && !tets;
    this.tets.mesh.visible = hasPositions && tets;
    this.lines.object.visible =
      hasPositions && state.wireframe && !(tets && state.explode > 0) && this.topology !== null;
    this.ghost.object.visible = state.scrub !== null;
  }

  /** Levels are what the wire says of tets; by any other colouring the cut is plain. */
  private showSectionTets({ cut, colouring }: Readonly<State>): void {
    const wanted = cut !== null && colouring === "level" ? this.topology : null;
    if (wanted === this.sectionTopology) return;
    this.sectionTopology = wanted;
    this.section.setTets(wanted);
  }

  /** Of solid tets that are there to be drawn; 0 while the surface is shown. */
  get tetCount(): number {
    return this.tets.mesh.visible ? this.tets.count : 0;
  }

  /** As the state says; by level while a field's values are not there yet. */
  colour(state: Readonly<State>, frame: Frame | null): void {
    if (!this.surface || !this.topology) return;
    const scale = scaleOf(state);
    const values = frame?.values?.field === state.colouring ? frame.values : null;
    if (scale && (values || !isField(state.colouring))) this.surface.colour({ scale, values });
    else this.surface.colour({ levels: this.topology.surfaceLevel });
  }

  sample(motion: Motion, now: number): void {
    if (!this.surface) return;
    const front = this.lines.object.visible || this.tets.mesh.visible || this.section.showsTets;
    motion.sample(now, this.surface.positions, front ? this.vertices.positions : null);
    this.surface.moved();
    if (front) this.vertices.moved();
  }

  /** The present, while the picture shows the past. */
  haunt(frame: Frame): void {
    this.ghost.move(frame);
  }

  /** Where a point of the surface is now. */
  point({ triangle, barycentric }: SurfacePlace): Vec3 {
    const { surface } = this;
    if (!surface || 3 * triangle >= surface.triangles.length) return [Infinity, Infinity, Infinity];
    return surfacePoint(surface.positions, surface.triangles, triangle, barycentric);
  }

  /** Whether a point is hidden by the cut. */
  hides(point: THREE.Vector3): boolean {
    return this.section.plane !== null && this.section.plane.distanceToPoint(point) < 0;
  }
}
