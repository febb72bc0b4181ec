// What a user can do, once: buttons and keys share it.

import type { Command } from "./protocol";
import { isPlaying, speedOf } from "./store";
import type { Store } from "./store";
import type { CameraRig } from "./viewer/camera";

/** Simulated seconds per real second that the toolbar offers. */
export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4] as const;
const ORBIT = Math.PI / 24;

export interface Actions {
  togglePlay(): void;
  step(): void;
  reset(): void;
  speed(value: number): void;
  faster(direction: 1 | -1): void;
  nextColouring(): void;
  toggleWireframe(): void;
  toggleTheme(): void;
  home(): void;
  orbit(azimuth: number, polar: number): void;
  zoom(factor: number): void;
}

export function makeActions(store: Store, send: (command: Command) => void, rig: CameraRig): Actions {
  const speed = (value: number) => send({ command: "speed", value });
  return {
    togglePlay: () => send({ command: isPlaying(store.get()) ? "pause" : "play" }),
    step: () => {
      if (isPlaying(store.get())) send({ command: "pause" });
      send({ command: "step", count: 1 });
    },
    reset: () => send({ command: "reset" }),
    speed,
    faster: (direction) => {
      const now = speedOf(store.get());
      const next =
        direction > 0 ? SPEEDS.find((s) => s > 1.001 * now) : [...SPEEDS].reverse().find((s) => s < 0.999 * now);
      if (next !== undefined) speed(next);
    },
    nextColouring: () => store.set({ colouring: store.get().colouring === "level" ? "stiffness" : "level" }),
    toggleWireframe: () => store.set({ wireframe: !store.get().wireframe }),
    toggleTheme: () => store.set({ dark: !store.get().dark }),
    home: () => rig.goHome(),
    orbit: (azimuth, polar) => rig.nudge(azimuth * ORBIT, polar * ORBIT),
    zoom: (factor) => rig.nudge(0, 0, factor),
  };
}
