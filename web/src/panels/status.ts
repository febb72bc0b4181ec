// The numbers: how fast, how many, how accurate. Each with its unit, and a dash when it is not known.

import { count, percent, significant } from "../format";
import { css, levelColour } from "../palette";
import type { LinkReport, SimulationState } from "../messages";
import type { State, Store } from "../store";
import { h } from "./dom";

const LINGER = 5000; // [ms] that a note on skipped frames stays after the last one

export function status(store: Store): HTMLElement {
  const rate = tile("Steps per second", "steps/s");
  const cost = tile("Time of the last step", "ms/step");
  const size = tile("Active tetrahedra, and vertices that are free to move", "tetrahedra");
  const error = tile("Estimated error of the displacement, relative", "error estimate");
  const bar = h("div", { className: "levels-bar", attributes: { "aria-hidden": "true" } });

  const showNumbers = ({ simulation: s, hello }: Readonly<State>) => {
    rate.set(s && s.steps_per_second > 0 ? significant(s.steps_per_second) : "–", pace(s, hello?.time_step));
    cost.set(s ? significant(s.milliseconds) : "–", s ? `${count(s.iterations)} iterations` : "");
    size.set(s ? count(sum(s.tets_by_level)) : "–", s ? `${count(s.free_vertices)} vertices` : "");
    error.set(s ? percent(s.estimate) : "–", s ? `tolerance ${percent(s.tolerance)}` : "");
    error.element.classList.toggle("over", s !== null && s.estimate > s.tolerance);
    error.meter(s ? s.estimate / s.tolerance : 0);
  };
  const showLevels = (levels: readonly number[] | undefined) => {
    const total = sum(levels ?? []);
    bar.replaceChildren(
      ...(levels ?? []).map((tets, level) => {
        const part = h("span");
        part.style.background = css(levelColour(level));
        part.style.flexGrow = String(total ? tets / total : 0);
        return part;
      }),
    );
  };
  store.watch((s) => s, showNumbers);
  store.watch(
    (s) => s.simulation?.tets_by_level.join(),
    () => showLevels(store.get().simulation?.tets_by_level),
  );
  const skipped = h("p", { className: "note" });
  // One hiccup is soon forgotten.
  let forgotten = 0;
  let timer: ReturnType<typeof setTimeout> | undefined;
  store.watch(
    (s) => s.framesDropped,
    (frames) => {
      clearTimeout(timer);
      skipped.hidden = frames === forgotten;
      skipped.textContent = `${count(frames - forgotten)} frames skipped: this page draws more slowly than they come`;
      timer = setTimeout(() => {
        forgotten = frames;
        skipped.hidden = true;
      }, LINGER);
    },
  );
  const network = h("p", { className: "note" });
  store.watch((s) => s.linkReport, showNetwork(network));
  return h(
    "section",
    { className: "status", attributes: { "aria-label": "Numbers" } },
    h("div", { className: "tiles" }, rate.element, cost.element, size.element, error.element),
    bar,
    skipped,
    network,
  );
}

/** Says so while the network or this page cannot take all frames. The counts are of the whole connection. */
function showNetwork(element: HTMLElement): (report: LinkReport | null) => void {
  let last: LinkReport | null = null;
  return (report) => {
    const sent = report && last ? report.sent - last.sent : 0;
    const dropped = report && last ? report.dropped - last.dropped : 0;
    last = report;
    const slow = dropped > 0.2 * (sent + dropped) && dropped > 2;
    element.hidden = !slow;
    const delay = report?.round_trip ? `, ${Math.round(1000 * report.round_trip)} ms there and back` : "";
    if (slow)
      element.textContent = `Slow connection or page: ${count(sent)} of ${count(sent + dropped)} frames arrive${delay}`;
  };
}

/** How fast simulated time runs, when that is not what was asked for. */
function pace(s: SimulationState | null, timeStep: number | undefined): string {
  if (!s || !timeStep) return "";
  if (!s.playing) return "paused";
  if (!(s.steps_per_second > 0)) return "";
  const real = s.steps_per_second * timeStep;
  const asked = s.speed === 1 ? "real time" : `${significant(s.speed)}× asked`;
  return Math.abs(real / s.speed - 1) < 0.05
    ? s.speed === 1
      ? "in real time"
      : `${significant(s.speed)}× real time`
    : `${significant(real, 2)}× ${asked}`;
}

const sum = (values: readonly number[]): number => values.reduce((a, b) => a + b, 0);

function tile(title: string, unit: string) {
  const value = h("strong", {}, "–");
  const note = h("small");
  const fill = h("i");
  const element = h("div", { className: "tile", title }, value, h("span", { className: "unit" }, unit), note);
  return {
    element,
    set(text: string, detail: string) {
      if (value.textContent !== text) value.textContent = text;
      if (note.textContent !== detail) note.textContent = detail;
    },
    meter(ratio: number) {
      if (!fill.parentElement)
        element.append(h("div", { className: "meter", attributes: { "aria-hidden": "true" } }, fill));
      fill.style.width = `${100 * Math.min(1, Math.max(0, ratio))}%`;
    },
  };
}
