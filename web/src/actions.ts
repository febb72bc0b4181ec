// What a user can do, once: buttons and keys share it.

import type { Command } from "./messages";
import { can, colouringsOf, isPlaying, speedOf } from "./store";
import type { Store } from "./store";
import type { CameraRig } from "./viewer/camera";
import type { Hands } from "./viewer/hands";

/** Simulated seconds per real second that the toolbar offers. */
export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4] as const;
const ORBIT = Math.PI / 24;
const PAN = 0.025; // of the picture's height
const REGION_STEP = 1.25;

export interface Actions {
  togglePlay(): void;
  step(): void;
  reset(): void;
  speed(value: number): void;
  faster(direction: 1 | -1): void;
  nextColouring(): void;
  toggleWireframe(): void;
  toggleTets(): void;
  toggleCut(): void;
  toggleTheme(): void;
  home(): void;
  orbit(azimuth: number, polar: number): void;
  zoom(factor: number): void;
  pan(right: number, up: number): void;
  pin(hold?: boolean): void;
  newForce(): void;
  removeForce(): void;
  stiffen(direction: 1 | -1): void;
  grab(): void;
  movePull(right: number, up: number, nearer: number): void;
  letGo(): void;
  resizeRegion(direction: 1 | -1): void;
  putDown(): void;
  toggleRecording(): void;
  live(): void;
}

export function makeActions(
  store: Store,
  send: (command: Command) => void,
  rig: CameraRig,
  hands: Pick<Hands, "pin" | "newForce" | "stiffen" | "grab" | "movePull" | "letGo">,
): Actions {
  const speed = (value: number) => send({ command: "speed", value });
  return {
    togglePlay: () => {
      store.set({ scrub: null });
      send({ command: isPlaying(store.get()) ? "pause" : "play" });
    },
    step: () => {
      store.set({ scrub: null });
      if (isPlaying(store.get())) send({ command: "pause" });
      send({ command: "step", count: 1 });
    },
    reset: () => {
      store.set({ scrub: null });
      hands.letGo();
      send({ command: "reset" });
    },
    speed,
    faster: (direction) => {
      const now = speedOf(store.get());
      const next =
        direction > 0 ? SPEEDS.find((s) => s > 1.001 * now) : [...SPEEDS].reverse().find((s) => s < 0.999 * now);
      if (next !== undefined) speed(next);
    },
    nextColouring: () => {
      const offered = colouringsOf(store.get().hello);
      const now = offered.findIndex(({ value }) => value === store.get().colouring);
      store.set({ colouring: offered[(now + 1) % offered.length].value, shape: "surface" });
    },
    toggleWireframe: () => store.set({ wireframe: !store.get().wireframe }),
    toggleTets: () => store.set({ shape: store.get().shape === "tets" ? "surface" : "tets" }),
    toggleCut: () => store.set({ cut: store.get().cut ? null : { axis: 0, at: 0.5, flip: false } }),
    toggleTheme: () => store.set({ dark: !store.get().dark }),
    home: () => rig.goHome(),
    orbit: (azimuth, polar) => rig.nudge(azimuth * ORBIT, polar * ORBIT),
    zoom: (factor) => rig.nudge(0, 0, factor),
    pan: (right, up) => rig.pan(right * PAN, up * PAN),
    pin: (hold) => hands.pin(hold),
    newForce: () => hands.newForce(),
    removeForce: () => {
      const { selectedForce: force } = store.get();
      if (force === null) return;
      send({ command: "force_remove", force });
      store.set({ selectedForce: null });
    },
    stiffen: (direction) => hands.stiffen(direction),
    grab: () => hands.grab(),
    movePull: (right, up, nearer) => hands.movePull(right, up, nearer),
    letGo: () => hands.letGo(),
    resizeRegion: (direction) => {
      const size = store.get().regionSize * REGION_STEP ** direction;
      store.set({ regionSize: Number(Math.min(50, Math.max(0.5, size)).toPrecision(3)) });
    },
    putDown: () => {
      hands.letGo();
      store.set({ tool: null });
    },
    toggleRecording: () => {
      if (!can(store.get(), "record")) return;
      if (store.get().recording?.active) send({ command: "record_stop" });
      else send({ command: "record_start", colouring: store.get().colouring });
    },
    live: () => store.set({ scrub: null }),
  };
}
