// What one can change of the simulation. A change acts at once; a value that the server refuses goes back to the server's.

import { areScenes, deepestLevel, sceneLevels, wantedLevels } from "../levels";
import type { Command, Levels, Vec3 } from "../messages";
import { can, isOpen } from "../store";
import type { State, Store } from "../store";
import { h } from "./dom";
import { follow, group, numberRow, resetButton, segments } from "./fields";
import type { NumberField } from "./fields";

type Send = (command: Command) => void;

const gravityOf = (s: Readonly<State>): Vec3 | undefined => s.simulation?.gravity ?? s.hello?.gravity;
const edits = (s: Readonly<State>): boolean => can(s, "edit");

export function physics(store: Store, send: Send): HTMLElement[] {
  const rows = [tolerance(store, send)];
  const front = [
    ...rows.map((field) => numberRow(store, field)),
    ...budgets(store, send).map((field) => numberRow(store, field)),
    order(store, send),
    levels(store, send),
  ];
  const material = [gravity(store, send), ...materials(store, send).map((field) => numberRow(store, field))];
  return [group("Accuracy and cost", true, ...front), group("Physics", true, ...material)];
}

function tolerance(store: Store, send: Send): NumberField {
  return {
    label: "Tolerance",
    unit: "%",
    spoken: "percent",
    title: "The front is refined until the estimated error is below this; smaller is more accurate and slower",
    low: 1e-4,
    high: 100,
    slider: "logarithmic",
    now: (s) => percent(s.simulation?.tolerance ?? s.hello?.tolerance),
    scene: (s) => percent(s.hello?.tolerance),
    change: (value) => value !== null && send({ command: "tolerance", value: value / 100 }),
    enabled: (s) => isOpen(s) && !store.get().hello?.recording,
  };
}

const percent = (x: number | undefined): number | undefined => (x === undefined ? undefined : 100 * x);

/** Changes one of several values that a command sets at once. What was said of the others counts before the server's answer is here. */
function together<T extends object>(
  store: Store,
  now: (state: Readonly<State>) => T | undefined,
  send: (all: T) => void,
): (change: Partial<T>) => void {
  let said: T | null = null;
  follow(store, now, () => (said = null));
  return (change) => {
    const known = said ?? now(store.get());
    if (!known) return;
    said = { ...known, ...change };
    send(said);
  };
}

function budgets(store: Store, send: Send): NumberField[] {
  const say = together(
    store,
    (s) => s.settings?.budget,
    ({ tets, milliseconds }) =>
      send({
        command: "budget",
        ...(tets === null ? {} : { tets: Math.round(tets) }),
        ...(milliseconds === null ? {} : { milliseconds }),
      }),
  );
  const field = (
    key: "tets" | "milliseconds",
    label: string,
    unit: string,
    low: number,
    high: number,
  ): NumberField => ({
    label,
    unit,
    title: "The front takes the best it can get within it; the error estimate says what that leaves",
    low,
    high,
    optional: true,
    now: (s) => s.settings?.budget[key],
    scene: (s) => (s.hello ? (s.hello.budget?.[key] ?? null) : undefined),
    change: (value) => say({ [key]: value }),
    enabled: edits,
  });
  return [field("tets", "Tet budget", "tets", 1, 2 ** 28), field("milliseconds", "Time budget", "ms/step", 0, 1e6)];
}

function order(store: Store, send: Send): HTMLElement {
  const choice = segments(
    store,
    "Order of the tetrahedra",
    [
      { value: 1, label: "Linear" },
      { value: 2, label: "Quadratic" },
    ],
    (s) => s.settings?.order ?? s.hello?.order,
    (value) => send({ command: "order", value }),
  );
  const reset = resetButton("Order", () => {
    const value = store.get().hello?.order;
    if (value !== undefined) send({ command: "order", value });
  });
  store.watch(
    (s) => s.settings === null || s.settings.order === s.hello?.order,
    (same) => (reset.hidden = same),
  );
  store.watch(edits, (on) => [...choice.inputs, reset].forEach((element) => (element.disabled = !on)));
  return h("div", { className: "value" }, h("span", { className: "name" }, "Order", reset), choice.element);
}

/** That the tets can have. */
function levels(store: Store, send: Send): HTMLElement {
  const deepest = ({ hello, settings }: Readonly<State>): number =>
    hello && settings?.levels ? deepestLevel(hello, settings.order) : 0;
  const change = (levels: Partial<Levels>) => {
    const { hello, settings } = store.get();
    if (!hello || !settings?.levels) return;
    const { min, max } = { ...settings.levels, ...levels };
    // Who moves one end beyond the other takes it along.
    const both = levels.max === undefined ? { min, max: Math.max(min, max) } : { min: Math.min(min, max), max };
    const wanted = wantedLevels(hello, { ...settings, levels: both });
    if (wanted) send({ command: "levels", ...wanted });
  };
  const choice = (label: string, end: "min" | "max") => {
    const select = h("select", {
      onchange: () => change({ [end]: Number(select.value) }),
      attributes: { "aria-label": label },
    });
    return select;
  };
  const coarsest = choice("Coarsest level", "min");
  const finest = choice("Finest level", "max");
  const isScenes = ({ hello, settings }: Readonly<State>) => !hello || !settings || areScenes(hello, settings);
  const reset = resetButton("Levels", () => {
    const { hello } = store.get();
    const levels = hello && wantedLevels(hello, { order: hello.order, levels: sceneLevels(hello) });
    if (levels) send({ command: "levels", ...levels });
  });
  const show = () => {
    const state = store.get();
    const numbers = Array.from({ length: deepest(state) + 1 }, (_, i) => String(i));
    const now = state.settings?.levels ?? { min: 0, max: 0 };
    for (const [select, level] of [[coarsest, now.min] as const, [finest, now.max] as const]) {
      if (select.length !== numbers.length)
        select.replaceChildren(...numbers.map((value) => h("option", { value }, value)));
      select.value = String(level);
    }
    reset.hidden = isScenes(state);
  };
  follow(store, (s) => JSON.stringify([s.settings?.levels, isScenes(s), deepest(s)]), show);
  store.watch(
    (s) => edits(s) && deepest(s) > 0,
    (on) => [coarsest, finest, reset].forEach((element) => (element.disabled = !on)),
  );
  const title = "Tets are of these levels only: 0 are the roots; each level has edges half as long as the one before";
  return h(
    "div",
    { className: "value", title },
    h("span", { className: "name" }, "Levels", reset),
    h("div", { className: "row range" }, coarsest, h("span", {}, "to"), finest),
  );
}

function materials(store: Store, send: Send): NumberField[] {
  const say = together(
    store,
    (s) => s.settings?.damping,
    (damping) => send({ command: "damping", ...damping }),
  );
  return [
    {
      label: "Stiffness scale",
      unit: "×",
      title: "Times the scene's stiffness, everywhere",
      low: 0.01,
      high: 100,
      slider: "logarithmic",
      now: (s) => s.settings?.stiffness_scale,
      scene: (s) => (s.settings ? 1 : undefined),
      change: (value) => value !== null && send({ command: "stiffness_scale", value }),
      enabled: edits,
    },
    {
      label: "Mass damping",
      unit: "1/s",
      title: "Rayleigh damping, on top of the materials' own: slows all motion",
      low: 0,
      high: 1000,
      now: (s) => s.settings?.damping.mass,
      scene: (s) => (s.settings ? 0 : undefined),
      change: (mass) => mass !== null && say({ mass }),
      enabled: edits,
    },
    {
      label: "Stiffness damping",
      unit: "s",
      title: "Rayleigh damping, on top of the materials' own: slows vibrations",
      low: 0,
      high: 10,
      now: (s) => s.settings?.damping.stiffness,
      scene: (s) => (s.settings ? 0 : undefined),
      change: (stiffness) => stiffness !== null && say({ stiffness }),
      enabled: edits,
    },
  ];
}

function gravity(store: Store, send: Send): HTMLElement {
  const change = (value: Vec3) => send({ command: "gravity", value });
  const inputs = ["x", "y", "z"].map((axis) =>
    h("input", {
      type: "number",
      step: "any",
      min: "-10000",
      max: "10000",
      onchange: () => {
        if (inputs.every((input) => input.value !== "" && input.reportValidity()))
          change(inputs.map((input) => Number(input.value)) as unknown as Vec3);
        else show();
      },
      attributes: { "aria-label": `Gravity along ${axis} in metres per second squared` },
    }),
  );
  const reset = resetButton("Gravity", () => {
    const value = store.get().hello?.gravity;
    if (value) change(value);
  });
  const show = () => {
    const value = gravityOf(store.get());
    if (value) inputs.forEach((input, i) => (input.value = String(Number(value[i].toPrecision(6)))));
    reset.hidden = value?.join() === store.get().hello?.gravity.join();
  };
  follow(store, (s) => `${gravityOf(s)} ${s.hello?.gravity}`, show);
  store.watch(edits, (on) => [...inputs, reset].forEach((element) => (element.disabled = !on)));
  return h(
    "div",
    { className: "value" },
    h("span", { className: "name" }, "Gravity ", h("small", {}, "m/s²"), reset),
    h(
      "div",
      { className: "row three" },
      ...inputs.map((input, i) =>
        h("label", { className: "field" }, h("span", { className: "axis" }, "xyz"[i]), input),
      ),
    ),
  );
}
