// A tool in the hand: a click or tap on the object makes what is there stiffer, softer or pinned, instead of pulling it. For those
// who have no keyboard, and with a rim that shows the region before. Taps beside the object and second fingers are the camera's.

import type * as THREE from "three";

import type { Place } from "../parts";
import type { Tool } from "../store";
import { isReplayed, replay } from "./replay";

export interface ToolEvents {
  tool: () => Tool | null;
  ray: (event: MouseEvent) => THREE.Ray;
  /** The region that is meant there. */
  region: (ray: THREE.Ray) => Place | null;
  use: (tool: Tool, ray: THREE.Ray) => void;
  changed: () => void;
}

const SLACK = 8; // [px] a tap may wander this far
const LOOK_INTERVAL = 60; // [ms] between looks at what is under the pointer
const FLASH = 1500; // [ms] a region is shown after a key has changed its size

export class ToolHand {
  /** What a tap would mean. */
  preview: Place | null = null;
  private held: PointerEvent | null = null; // where the finger or button is that the camera does not know of
  private tapped: PointerEvent | null = null; // until it wanders
  private looked = 0;
  private until = 0; // [ms] a region is shown without a tool

  constructor(
    private readonly element: HTMLElement,
    private readonly events: ToolEvents,
  ) {
    const parent = element.parentElement ?? element;
    parent.addEventListener("pointerdown", (event) => this.down(event), { capture: true });
    element.addEventListener("pointermove", (event) => this.move(event));
    element.addEventListener("pointerup", (event) => this.up(event));
    for (const kind of ["pointercancel", "lostpointercapture"] as const)
      element.addEventListener(kind, () => (this.held = this.tapped = null));
  }

  /** The region's size has changed: it is shown for a moment. */
  flash(now: number): void {
    this.until = now + FLASH;
    this.looked = 0;
  }

  /** Once per turn of the drawing loop, at `now` [ms]; `ray`: to what a key would mean. */
  tick(now: number, ray: () => THREE.Ray): void {
    const wanted = this.events.tool() !== null || now < this.until;
    this.element.classList.toggle("tool", this.events.tool() !== null);
    if (wanted ? now - this.looked < LOOK_INTERVAL : this.preview === null) return;
    this.looked = now;
    const before = this.preview;
    this.preview = wanted && this.events.tool() !== "force" ? this.events.region(ray()) : null; // a force has a point
    if (JSON.stringify(this.preview) !== JSON.stringify(before)) this.events.changed();
  }

  private down(event: PointerEvent): void {
    if (isReplayed(event)) return;
    const { held } = this;
    this.held = this.tapped = null;
    if (held && event.pointerType === "touch" && !event.isPrimary) return replay(this.element, held);
    if (event.target !== this.element || event.button !== 0 || event.shiftKey || !event.isPrimary) return;
    if (this.events.tool() === null || !this.events.region(this.events.ray(event))) return;
    event.stopImmediatePropagation(); // neither a pull nor the camera
    this.element.setPointerCapture(event.pointerId);
    this.held = this.tapped = event;
  }

  private move(event: PointerEvent): void {
    const { held, tapped } = this;
    if (held?.pointerId === event.pointerId) this.held = event;
    if (tapped && Math.hypot(event.clientX - tapped.clientX, event.clientY - tapped.clientY) > SLACK)
      this.tapped = null;
  }

  private up(event: PointerEvent): void {
    const tool = this.events.tool();
    if (this.held?.pointerId === event.pointerId) this.held = null;
    if (this.tapped?.pointerId !== event.pointerId || tool === null) return;
    this.tapped = null;
    this.events.use(tool, this.events.ray(event));
  }
}
