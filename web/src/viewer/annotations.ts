// What lies over the object: pulls, forces that stay, pins.

import type { Force, Pin, Vec3 } from "../messages";
import type { Frame } from "../protocol";
import type { State } from "../store";
import type { Band } from "./bands";
import type { ForceHand } from "./forces";
import { surfacePoint } from "./pick";
import { lastWord } from "./pins";
import type { Grip } from "./pull";
import type { SceneForces } from "./scene_forces";
import type { SurfaceMesh } from "./surface";

/** All forces, the one that is held as the hand has it, each with its place on the surface now. */
export function forcesOf(
  { settings }: Readonly<State>,
  surface: SurfaceMesh | null,
  hand: ForceHand,
): { force: Force; at: Vec3 }[] {
  if (!surface) return [];
  const { held } = hand;
  const others = (settings?.forces ?? []).filter(({ force }) => force !== held?.force);
  const count = surface.triangles.length / 3;
  return [...others, ...(held ? [held] : [])]
    .filter(({ triangle }) => triangle < count)
    .map((force) => ({
      force,
      at: surfacePoint(surface.positions, surface.triangles, force.triangle, force.barycentric),
    }));
}

export function annotations(
  state: Readonly<State>,
  frame: Frame | null,
  surface: SurfaceMesh | null,
  grip: Grip | null,
  hand: ForceHand,
  scene: SceneForces,
): Band[] {
  if (!surface) return [];
  const bands = pulls(frame, surface, grip);
  // Of the past it is not known which of the scene's forces acted.
  if (state.scrub === null)
    for (const { at, value } of scene.at(surface.positions))
      bands.push({ from: at, to: hand.tip(at, value), force: Math.hypot(...value), kind: "force" });
  for (const { force, at } of forcesOf(state, surface, hand)) {
    const kind = force.force === state.selectedForce ? "selected" : "force";
    bands.push({ from: at, to: hand.tip(at, force.value), force: Math.hypot(...force.value), kind });
  }
  for (const at of heldPlaces(state.settings?.pins ?? [], surface))
    bands.push({ from: at, to: at, force: null, kind: "pin" });
  return bands;
}

/** The middles of pins that nothing said later lets go. */
export function heldPlaces(
  pins: readonly Pin[],
  { positions, triangles }: Pick<SurfaceMesh, "positions" | "triangles">,
): [number, number, number][] {
  const places = pins
    .filter(({ triangle }) => 3 * triangle < triangles.length)
    .map((pin) => ({ ...pin, at: surfacePoint(positions, triangles, pin.triangle, pin.barycentric) }));
  return places
    .filter(({ at, pinned }) => {
      const away = (other: { at: Vec3 }) => Math.hypot(...other.at.map((x, i) => x - at[i]));
      return pinned && lastWord(places, away)?.pinned;
    })
    .map(({ at }) => at);
}

/** The own pull follows the pointer at once; its force is the server's, from the frame's nearest pull. */
function pulls(frame: Frame | null, surface: SurfaceMesh, grip: Grip | null): Band[] {
  const bands: Band[] = [];
  const data = frame?.pulls ?? new Float32Array(0);
  for (let i = 0; i < data.length; i += 7)
    bands.push({
      from: [data[i], data[i + 1], data[i + 2]],
      to: [data[i + 3], data[i + 4], data[i + 5]],
      force: data[i + 6],
      kind: "other",
    });
  if (!grip) return bands;
  const from = surfacePoint(surface.positions, surface.triangles, grip.triangle, grip.barycentric);
  const away = (band: Band) => Math.hypot(...band.from.map((x, i) => x - from[i]));
  const mine = grip.begun
    ? bands.reduce((best, band, i) => (i === 0 || away(band) < away(bands[best]) ? i : best), 0)
    : -1;
  const force = mine >= 0 && bands.length > 0 ? bands.splice(mine, 1)[0].force : null;
  bands.unshift({ from, to: grip.target, force, kind: "own" });
  return bands;
}
