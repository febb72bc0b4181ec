// Play, step, reset, speed and the clock: the row at the bottom.

import { SPEEDS } from "../actions";
import type { Actions } from "../actions";
import { duration } from "../format";
import { isOpen, isPlaying, speedOf } from "../store";
import type { Store } from "../store";
import { h, icon, iconButton } from "./dom";

export function toolbar(store: Store, actions: Actions): HTMLElement {
  const play = iconButton("play", "Play", "Space", actions.togglePlay);
  play.classList.add("primary");
  const step = iconButton("step", "One step", "→", actions.step);
  const reset = iconButton("reset", "Reset", "R", actions.reset);
  const speed = h("select", {
    title: "Simulated seconds per real second (+ and −)",
    onchange: () => actions.speed(Number(speed.value)),
    attributes: { "aria-label": "Speed" },
  });
  const clock = h("output", {
    className: "clock",
    title: "Simulated time",
    attributes: { "aria-label": "Simulated time" },
  });
  const buttons = [play, step, reset, speed];

  store.watch(isOpen, (open) => buttons.forEach((button) => (button.disabled = !open)));
  store.watch(isPlaying, (playing) => {
    const label = playing ? "Pause" : "Play";
    play.replaceChildren(icon(playing ? "pause" : "play"));
    play.title = `${label} (Space)`;
    play.setAttribute("aria-label", label);
  });
  store.watch(speedOf, (value) => {
    const values = [...new Set([...SPEEDS, value])].sort((a, b) => a - b);
    speed.replaceChildren(...values.map((v) => h("option", { value: String(v), textContent: `${v}×` })));
    speed.value = String(value);
  });
  store.watch(
    (s) => s.simulation?.time ?? null,
    (time) => (clock.textContent = time === null ? "–" : duration(time)),
  );
  return h(
    "nav",
    { className: "card toolbar", attributes: { "aria-label": "Simulation" } },
    reset,
    play,
    step,
    speed,
    clock,
  );
}
