// Play, step, reset, speed, time and recording: the row at the bottom.

import { SPEEDS } from "../actions";
import type { Actions } from "../actions";
import { bytes, duration } from "../format";
import type { Command } from "../messages";
import { can, isOpen, isPlaying, speedOf } from "../store";
import type { Store } from "../store";
import { h, icon, iconButton } from "./dom";
import { follow, resetButton } from "./fields";
import { timeline } from "./timeline";

export function toolbar(
  store: Store,
  actions: Actions,
  send: (command: Command) => void,
  range: () => readonly [number, number],
): HTMLElement {
  const play = iconButton("play", "Play", "Space", actions.togglePlay);
  play.classList.add("primary");
  const step = iconButton("step", "One step", "→", actions.step);
  const reset = iconButton("reset", "Reset", "R", actions.reset);
  const speed = h("select", {
    title: "Simulated seconds per real second (+ and −)",
    onchange: () => actions.speed(Number(speed.value)),
    attributes: { "aria-label": "Speed" },
  });
  store.watch(isPlaying, (playing) => {
    const label = playing ? "Pause" : "Play";
    play.replaceChildren(icon(playing ? "pause" : "play"));
    play.title = `${label} (Space)`;
    play.setAttribute("aria-label", label);
  });
  const regular = resetButton("Speed", () => actions.speed(1));
  regular.classList.add("regular");
  regular.title = "Back to 1×";
  const buttons = [play, step, reset, speed, regular];
  follow(store, speedOf, () => {
    const value = speedOf(store.get());
    regular.hidden = value === 1;
    const values = [...new Set([...SPEEDS, value])].sort((a, b) => a - b);
    speed.replaceChildren(...values.map((v) => h("option", { value: String(v), textContent: `${v}×` })));
    speed.value = String(value);
  });
  store.watch(isOpen, (open) => buttons.forEach((button) => (button.disabled = !open)));
  return h(
    "nav",
    { className: "card toolbar", attributes: { "aria-label": "Simulation" } },
    reset,
    play,
    step,
    speed,
    regular,
    ...timeline(store, send, range),
    recordButton(store, actions),
  );
}

/** Hidden where the server cannot record; while it does, says how much. */
function recordButton(store: Store, actions: Actions): HTMLElement {
  const text = h("span");
  const button = h(
    "button",
    { type: "button", className: "record", onclick: actions.toggleRecording },
    icon("record"),
    text,
  );
  store.watch(
    (s) => can(s, "record"),
    (able) => (button.hidden = !able),
  );
  store.watch(
    (s) => s.recording,
    (recording) => {
      const active = recording?.active ?? false;
      button.classList.toggle("active", active);
      button.title = active ? "End the recording (V)" : "Record on the server (V)";
      button.setAttribute("aria-label", active ? "End the recording" : "Record");
      text.textContent = recording && active ? `${duration(recording.seconds)} · ${bytes(recording.bytes)}` : "";
      text.hidden = !active;
    },
  );
  return button;
}
