// The page's address says what it shows, so that a link shows the same to somebody else: the view, and what of the
// simulation is not as the scene has it. In the fragment, which is not sent to the server:
//
//     http://127.0.0.1:8080/#scene=bunny&colour=stress&cut=x,0.4&tolerance=0.01
//
// It is taken over when the page is opened or the address changed, and only for the scene that it was made for: address.ts.

import { areScenes, wantedLevels } from "./levels";
import type { Budget, Command, Vec3 } from "./messages";
import { COLOURINGS } from "./scale";
import { viewOf } from "./store";
import type { Cut, State, View } from "./store";

const NO_CUT = "none"; // of a scene that has one

/** What differs from the scene, as a fragment without its "#". */
export function toFragment(state: Readonly<State>, camera: readonly number[] | null): string {
  const { hello, simulation, settings } = state;
  const out = new URLSearchParams();
  const put = (key: string, value: string | number | null | undefined, usual: unknown) => {
    if (value !== null && value !== undefined && value !== usual) out.set(key, String(value));
  };
  if (!hello) return "";
  const scene = viewOf(hello);
  put("colour", state.colouring, scene.colouring);
  put("wire", state.wireframe ? 1 : 0, scene.wireframe ? 1 : 0);
  put("shape", state.shape, scene.shape);
  put("explode", round(state.explode), 0);
  put("cut", cutText(state.cut), cutText(scene.cut));
  if (camera) put("camera", camera.map(round).join(), "");
  put("speed", simulation?.speed, 1);
  put("tolerance", simulation?.tolerance, hello.tolerance);
  put("gravity", simulation?.gravity.join(), hello.gravity.join());
  put("stiffness", settings?.stiffness_scale, 1);
  put("order", settings?.order, hello.order);
  const levels = settings && !areScenes(hello, settings) && wantedLevels(hello, settings);
  if (levels) put("levels", `${levels.min},${levels.max}`, "");
  if (settings) {
    const { mass, stiffness } = settings.damping;
    put("damping", `${mass},${stiffness}`, "0,0");
    put("budget", budgetText(settings.budget), budgetText(hello.budget));
  }
  if (out.size === 0) return "";
  return `scene=${encodeURIComponent(hello.scene.name)}&${out.toString().replace(/%2C/g, ",")}`;
}

export interface Shared {
  scene: string;
  view: Partial<View>;
  camera: { eye: Vec3; target: Vec3 } | null;
  commands: Command[];
}

/** Reads a fragment; what cannot be understood is left away. */
export function fromFragment(fragment: string): Shared {
  const query = new URLSearchParams(fragment.replace(/^#/, ""));
  const numbers = (key: string, count: number): number[] | null => {
    const list = (query.get(key) ?? "").split(",").map((x) => (x.trim() === "" ? NaN : Number(x)));
    return list.length === count && list.every(Number.isFinite) ? list : null;
  };
  const number = (key: string): number | undefined => numbers(key, 1)?.[0];
  const view: Partial<View> = {};
  const colour = COLOURINGS.find(({ value }) => value === query.get("colour"))?.value;
  if (colour) view.colouring = colour;
  if (query.has("wire")) view.wireframe = query.get("wire") === "1";
  if (query.get("shape") === "tets") view.shape = "tets";
  const explode = number("explode");
  if (explode !== undefined) view.explode = Math.min(1, Math.max(0, explode));
  const cut = parseCut(query.get("cut"));
  if (cut || query.get("cut") === NO_CUT) view.cut = cut;

  const commands: Command[] = [];
  const set = (command: "speed" | "tolerance" | "order", key: string) => {
    const value = number(key);
    if (value !== undefined) commands.push({ command, value });
  };
  set("speed", "speed");
  set("tolerance", "tolerance");
  set("order", "order");
  const levels = numbers("levels", 2);
  if (levels) commands.push({ command: "levels", min: levels[0], max: levels[1] });
  const scale = number("stiffness");
  if (scale !== undefined) commands.push({ command: "stiffness_scale", value: scale });
  const gravity = numbers("gravity", 3);
  if (gravity) commands.push({ command: "gravity", value: gravity as unknown as Vec3 });
  const damping = numbers("damping", 2);
  if (damping) commands.push({ command: "damping", mass: damping[0], stiffness: damping[1] });
  const [tets, milliseconds] = (query.get("budget") ?? "").split(",").map((x) => (x ? Number(x) : NaN));
  if (query.has("budget"))
    commands.push({
      command: "budget",
      ...(Number.isFinite(tets) ? { tets } : {}),
      ...(Number.isFinite(milliseconds) ? { milliseconds } : {}),
    });
  const camera = numbers("camera", 6);
  return {
    scene: query.get("scene") ?? "",
    view,
    camera: camera && {
      eye: camera.slice(0, 3) as unknown as Vec3,
      target: camera.slice(3) as unknown as Vec3,
    },
    commands,
  };
}

function parseCut(text: string | null): Cut | null {
  const match = /^([xyz]),([\d.]+)(,flip)?$/.exec(text ?? "");
  if (!match) return null;
  const at = Number(match[2]);
  if (!(at >= 0 && at <= 1)) return null;
  return { axis: "xyz".indexOf(match[1]) as Cut["axis"], at, flip: match[3] !== undefined };
}

const cutText = (cut: Cut | null): string =>
  cut ? `${"xyz"[cut.axis]},${round(cut.at)}${cut.flip ? ",flip" : ""}` : NO_CUT;

const budgetText = (budget?: Budget): string => `${budget?.tets ?? ""},${budget?.milliseconds ?? ""}`;

const round = (x: number): number => Number(x.toPrecision(4));
