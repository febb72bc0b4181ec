// What a step costs and how accurate it is, over the last seconds of simulated time.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";

import { count, quantity, significant } from "../format";
import { css, levelColour } from "../palette";
import { PHASES, Series, stack } from "../series";
import type { Store } from "../store";
import { niceStep } from "../viewer/stage";
import { h } from "./dom";

const SIZE = { width: 248, height: 70 };
const PHASE_COLOURS = ["#7c6fd6", "#3f8fd0", "#2aa79b", "#d98a2b", "#9aa3b2"];

interface Plot {
  title: string;
  unit: string;
  series: { name: string; colour: string; filled?: boolean; dashed?: boolean }[];
  data: (series: Series) => (readonly (number | null)[])[];
  value: (x: number) => string;
  /** What the headline says, from the newest values. */
  now: (series: Series) => string;
}

export function plots(store: Store): HTMLElement {
  const element = h("section", { className: "card plots", id: "plots", attributes: { "aria-label": "Plots" } });
  const series = new Series();
  let charts: { update: () => void; destroy: () => void }[] = [];
  let kind = "";

  const build = () => {
    for (const chart of charts) chart.destroy();
    charts = [];
    element.replaceChildren();
    const { phases, energy } = store.get().simulation ?? {};
    for (const plot of plotsFor(series.levels.length, phases !== undefined, energy !== undefined))
      charts.push(draw(element, plot, series));
    for (const chart of charts) chart.update();
  };
  store.watch(
    (s) => s.simulation,
    (state) => {
      if (!state || !series.push(state)) return;
      const wanted = `${series.levels.length} ${state.phases !== undefined} ${state.energy !== undefined}`;
      if (wanted !== kind) {
        kind = wanted;
        build();
      } else if (!element.hidden) {
        for (const chart of charts) chart.update();
      }
    },
  );
  store.watch(
    (s) => s.hello?.scene.name,
    () => series.clear(),
  );
  store.watch((s) => s.dark, build);
  // What came while they were hidden.
  new MutationObserver(() => !element.hidden && charts.forEach((chart) => chart.update())).observe(element, {
    attributeFilter: ["hidden"],
  });
  return element;
}

function plotsFor(levels: number, phases: boolean, energy: boolean): Plot[] {
  const last = (column: readonly (number | null)[]) => column.at(-1) ?? NaN;
  const sum = (columns: readonly (readonly number[])[]) => columns.reduce((s, column) => s + (column.at(-1) ?? 0), 0);
  const list: Plot[] = [
    {
      title: "Tetrahedra by level",
      unit: "",
      series: Array.from({ length: levels }, (_, level) => ({
        name: `level ${level}`,
        colour: css(levelColour(level)),
        filled: true,
      })),
      data: (s) => stack(s.levels),
      value: count,
      now: (s) => count(sum(s.levels)),
    },
    {
      title: phases ? "Step by phase" : "Step",
      unit: "ms",
      series: PHASES.map((name, i) => ({ name, colour: PHASE_COLOURS[i], filled: true })).slice(phases ? 0 : -1),
      data: (s) => stack(phases ? s.phases : s.phases.slice(-1)),
      value: significant,
      now: (s) => `${significant(sum(s.phases), 2)} ms`,
    },
    {
      title: "Error estimate",
      unit: "%",
      series: [
        { name: "estimate", colour: "#c2186b" },
        { name: "tolerance", colour: "#8a94a6", dashed: true },
      ],
      data: (s) => [s.estimate, s.tolerance],
      value: significant,
      now: (s) => `${significant(last(s.estimate), 2)} %`,
    },
    {
      title: "Energy",
      unit: "J",
      series: [
        { name: "elastic", colour: "#2a9d5c" },
        { name: "kinetic", colour: "#3f7fd0" },
      ],
      data: (s) => [s.elastic, s.kinetic],
      value: significant,
      now: (s) => quantity(last(s.elastic) + last(s.kinetic), "J"),
    },
  ];
  return energy ? list : list.slice(0, -1);
}

/** What the axis of time shows [s]: two seconds at least. */
function seconds(time: readonly number[]): [number, number] {
  const start = time[0] ?? 0;
  return [start, Math.max(time.at(-1) ?? 0, start + 2)];
}

function draw(parent: HTMLElement, plot: Plot, series: Series) {
  const style = getComputedStyle(document.documentElement);
  const soft = style.getPropertyValue("--soft").trim();
  const line = style.getPropertyValue("--line").trim();
  const now = h("b", {}, "");
  const keys = plot.series.map(({ name, colour }) => {
    const dot = h("i");
    dot.style.background = colour;
    return h("span", {}, dot, name);
  });
  const heading = h("h2", {}, plot.title, now);
  const place = h("div", { className: "plot", attributes: { role: "img", "aria-label": `${plot.title} over time` } });
  parent.append(heading, place, h("p", { className: "keys" }, ...keys));
  const axis = { stroke: soft, font: "10px system-ui, sans-serif", ticks: { show: false } };
  const chart = new uPlot(
    {
      ...SIZE,
      legend: { show: false },
      cursor: { show: false },
      padding: [4, 10, 0, 0],
      scales: {
        x: { time: false, range: () => seconds(series.time) }, // of a single moment uPlot would show 100 s
        y: { range: (_, low, high) => [Math.min(0, low ?? 0), 1.08 * Math.max(high ?? 0, 1e-9)] },
      },
      axes: [
        {
          ...axis,
          size: 20,
          gap: 6,
          grid: { show: false },
          space: 60,
          values: (_, ticks) => ticks.map((t) => `${t} s`),
        },
        {
          ...axis,
          size: 40,
          gap: 4,
          splits: (_, __, low, high) => (low < 0 ? [low, 0, niceStep(high)] : [0, niceStep(high)]),
          grid: { stroke: line, width: 1 },
          values: (_, ticks) => ticks.map((t) => (Math.abs(t) >= 1000 ? `${significant(t / 1000)}k` : significant(t))),
        },
      ],
      series: [
        {},
        // The tallest of a stack first: the ones below it are drawn over it.
        ...[...plot.series].reverse().map(({ colour, filled, dashed }) => ({
          stroke: colour,
          width: filled ? 1 : 1.5,
          points: { show: false },
          ...(filled ? { fill: colour } : {}),
          ...(dashed ? { dash: [4, 3] } : {}),
        })),
      ],
    },
    [[], ...plot.series.map(() => [])],
    place,
  );
  return {
    update: () => {
      chart.setData([series.time, ...[...plot.data(series)].reverse()] as uPlot.AlignedData);
      now.textContent = series.time.length ? plot.now(series) : "";
    },
    destroy: () => chart.destroy(),
  };
}
