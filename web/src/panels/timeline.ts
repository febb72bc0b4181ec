// Looks back: a slider over the last seconds of a simulation, or over a whole recording. While one looks at the past, the
// present goes on and is shown as a ghost.

import { clock, duration } from "../format";
import type { Command } from "../messages";
import { isOpen } from "../store";
import type { Store } from "../store";
import { h, throttle } from "./dom";

export function timeline(
  store: Store,
  send: (command: Command) => void,
  range: () => readonly [number, number],
): HTMLElement[] {
  const seek = throttle(60, (time: number) => send({ command: "seek", time }));
  const slider = h("input", {
    type: "range",
    className: "timeline",
    min: "0",
    step: "any",
    oninput: () => {
      if (store.get().hello?.recording) {
        seek(Number(slider.value));
        return;
      }
      const [start, end] = range();
      const time = Number(slider.value);
      // At the right end is the present.
      store.set({ scrub: end > start && time < end - 0.01 * (end - start) ? time : null });
    },
    attributes: { "aria-label": "Time" },
  });
  const live = h(
    "button",
    { type: "button", className: "live", onclick: () => store.set({ scrub: null }), title: "Back to the present (L)" },
    "Live",
  );
  const display = h("output", {
    className: "clock",
    title: "Simulated time",
    attributes: { "aria-label": "Simulated time" },
  });
  const show = () => {
    const { hello, simulation, scrub } = store.get();
    const [start, end] = hello?.recording ? [hello.recording.start, hello.recording.end] : range();
    const now = simulation?.time ?? null;
    slider.min = String(start);
    slider.max = String(Math.max(end, start + 1e-9));
    slider.disabled = !isOpen(store.get()) || !(end > start);
    slider.value = String(scrub ?? (hello?.recording ? (now ?? start) : end));
    slider.title = hello?.recording
      ? "Where the recording is"
      : `The last ${duration(end - start)} of the simulation, kept by this page`;
    const shown = scrub ?? now ?? NaN;
    const text = clock(shown);
    if (display.textContent !== text) display.textContent = text;
    slider.setAttribute("aria-valuetext", duration(shown));
    live.hidden = scrub === null;
  };
  for (const part of ["hello", "simulation", "scrub", "link", "refusals"] as const) store.watch((s) => s[part], show);
  return [slider, live, display];
}
