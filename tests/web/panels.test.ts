import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { makeActions, SPEEDS } from "../../web/src/actions";
import { clock, count, duration, percent, quantity, quantityOfLength, significant } from "../../web/src/format";
import { bindings, findBinding, ownKeys } from "../../web/src/keys";
import { aimsAtMiddle } from "../../web/src/panels/aim";
import { troubleOf } from "../../web/src/panels/banner";
import { throttle } from "../../web/src/panels/dom";
import { modeOf } from "../../web/src/panels/modes";
import type { Hello, Settings, SimulationState } from "../../web/src/messages";
import { initialState, Store, wantsReset } from "../../web/src/store";
import type { State } from "../../web/src/store";
import type { CameraRig } from "../../web/src/viewer/camera";

describe("numbers", () => {
  it.each([
    [1234567, "1.23 MPa"],
    [999, "999 Pa"],
    [999.6, "1 kPa"],
    [-2500, "−2.5 kPa"],
    [0.0123, "0.0123 Pa"],
    [0, "0 Pa"],
    [NaN, "–"],
  ])("%d Pa is %s", (value, text) => expect(quantity(value, "Pa")).toBe(text));

  it("are short", () => {
    expect(significant(0.000012345)).toBe("1.2e−5");
    expect(significant(16.6667)).toBe("16.7");
    expect(percent(0.0214)).toBe("2.1 %");
    expect(count(1234567)).toBe("1\u202f234\u202f567");
    expect([duration(3.254), duration(125)]).toEqual(["3.25 s", "2 min 5.0 s"]);
    expect([clock(3.254), clock(125), clock(3599.9), clock(NaN)]).toEqual(["3.25 s", "2:05.0", "59:59.9", "–"]);
    expect([0.002, 0.01, 0.2, 1, 2000].map(quantityOfLength)).toEqual(["2 mm", "1 cm", "20 cm", "1 m", "2 km"]);
  });
});

describe("keys", () => {
  const send = vi.fn();
  const rig = { goHome: vi.fn(), nudge: vi.fn(), pan: vi.fn() } as unknown as CameraRig;
  const store = new Store({ ...initialState });
  const hands = {
    ...{ pin: vi.fn(), newForce: vi.fn(), stiffen: vi.fn() },
    ...{ grab: vi.fn(), movePull: vi.fn(), letGo: vi.fn() },
  };
  const page = { help: vi.fn(), plots: vi.fn(), scenes: vi.fn(), snapshot: vi.fn() };
  const table = bindings(makeActions(store, send, rig, hands), page);
  const press = (key: string, modifiers = {}, pulling = false) => {
    const none = { shiftKey: false, ctrlKey: false, metaKey: false, altKey: false };
    const binding = findBinding(table, { key, ...none, ...modifiers }, pulling);
    return binding && { ...binding, run: () => binding.run(key.toLowerCase()) };
  };
  const state = (patch: Partial<SimulationState>) => store.set({ simulation: patch as SimulationState });
  beforeEach(() => void vi.clearAllMocks());

  it("belong to one action each", () => {
    for (const pulling of [false, true]) {
      const all = table.filter(({ whilePulling = false }) => whilePulling === pulling).flatMap(({ keys }) => keys);
      expect(all.length).toBeGreaterThan(0);
      expect(new Set(all).size).toBe(all.length);
    }
  });

  it("leave the browser's own combinations alone", () => {
    expect(press("r", { ctrlKey: true })).toBeUndefined();
    expect(press("c", { metaKey: true })).toBeUndefined();
    expect(press("R", { shiftKey: true })?.what).toMatch(/Reset/);
    expect(press("?", { shiftKey: true })?.what).toMatch(/sheet/);
    expect(press("ArrowRight", { shiftKey: true })?.what).toMatch(/Orbit/);
    expect(press("S", { shiftKey: true })?.what).toMatch(/canvas/);
    expect(press("s")?.what).toMatch(/server/);
    expect(press("ArrowLeft")).toBeUndefined();
  });

  it("play or pause, by what the server says", () => {
    state({ playing: true });
    press(" ")?.run();
    state({ playing: false });
    press(" ")?.run();
    expect(send.mock.calls).toEqual([[{ command: "pause" }], [{ command: "play" }]]);
  });

  it("pause before a single step", () => {
    state({ playing: true });
    press("ArrowRight")?.run();
    expect(send.mock.calls.map(([command]) => command.command)).toEqual(["pause", "step"]);
  });

  it("walk through the speeds and stop at the ends", () => {
    state({ speed: 1 });
    press("+")?.run();
    state({ speed: 0.3 });
    press("-")?.run();
    state({ speed: SPEEDS[SPEEDS.length - 1] });
    press("+")?.run();
    expect(send.mock.calls).toEqual([[{ command: "speed", value: 2 }], [{ command: "speed", value: 0.25 }]]);
  });

  it("make stiffer and softer, and change the size of what is taken, within its limits", () => {
    press("k")?.run();
    press("K", { shiftKey: true })?.run();
    expect(hands.stiffen.mock.calls).toEqual([[1], [-1]]);
    press("]")?.run();
    expect(store.get().regionSize).toBeCloseTo(1.25 * initialState.regionSize, 1);
    press(",")?.run();
    expect(store.get().regionSize).toBeCloseTo(initialState.regionSize, 1);
    for (let i = 0; i < 30; ++i) press("[")?.run();
    expect(store.get().regionSize).toBe(0.5);
    for (let i = 0; i < 30; ++i) press("]")?.run();
    expect(store.get().regionSize).toBe(50);
    store.set({ tool: "pin" });
    press("Escape")?.run();
    expect(store.get().tool).toBeNull();
    expect(send).not.toHaveBeenCalled();
  });

  it("move the hand while it pulls by keys, and do all else as ever", () => {
    const moves = ["ArrowRight", "ArrowUp", "ArrowLeft", "ArrowDown", "PageUp", "PageDown"];
    for (const key of moves) press(key, {}, true)?.run();
    expect(hands.movePull.mock.calls).toEqual([
      [1, 0, 0],
      [0, 1, 0],
      [-1, 0, 0],
      [0, -1, 0],
      [0, 0, 1],
      [0, 0, -1],
    ]);
    expect(send).not.toHaveBeenCalled();
    for (const key of ["Enter", "Escape"]) press(key, {}, true)?.run();
    expect(hands.letGo).toHaveBeenCalledTimes(2);
    expect(press("ArrowUp", { shiftKey: true }, true)?.what).toMatch(/Orbit/);
    expect(press(" ", {}, true)?.what).toMatch(/Play/);
    expect(press("Enter")).toBeUndefined();
    expect(press("ArrowRight")?.what).toMatch(/step/);
  });

  it("move the view as they lie on a number block", () => {
    for (const key of ["4", "6", "8", "2"]) press(key)?.run();
    const ways = (rig.pan as ReturnType<typeof vi.fn>).mock.calls.map((way) => way.map(Math.sign));
    expect(ways).toEqual([
      [-1, 0],
      [1, 0],
      [0, 1],
      [0, -1],
    ]);
  });

  it.each([
    ["input", "range", ["ArrowLeft", "PageUp", "Home"], ["w", " ", "Enter"]],
    ["input", "radio", ["ArrowLeft", " "], ["w", "PageUp"]],
    ["input", "checkbox", [" "], ["w", "ArrowLeft"]],
    ["input", "number", ["1", "ArrowUp", "w", " "], []],
    ["select", "", ["ArrowDown", "1", " "], []],
    ["summary", "", [" ", "Enter"], ["w", "ArrowLeft"]],
    ["button", "", [" ", "Enter"], ["w", "ArrowLeft"]],
    ["canvas", "", [], [" ", "Enter", "w", "ArrowLeft"]],
  ])("%s %s has some of its own", (element, type, own, others) => {
    const takes = (key: string) => ownKeys(element, type)?.includes(key) ?? true;
    expect(own.filter((key) => !takes(key))).toEqual([]);
    expect(others.filter(takes)).toEqual([]);
  });

  it("switch colouring and wireframe without asking the server", () => {
    press("c")?.run();
    press("w")?.run();
    expect(store.get()).toMatchObject({ colouring: "stiffness", wireframe: true });
    expect(send).not.toHaveBeenCalled();
  });
});

describe("trouble", () => {
  const trouble = (simulation: Partial<SimulationState> | null) =>
    troubleOf({ ...initialState, simulation: simulation as SimulationState | null });
  it("is silent when all is well", () => {
    expect(trouble(null)).toBe("");
    expect(trouble({ warning: "", converged: true })).toBe("");
  });
  it("tells the server's warning first, then a solver that did not converge", () => {
    expect(trouble({ warning: "diverged", converged: false })).toBe("diverged");
    expect(trouble({ warning: "", converged: false })).toMatch(/solver/);
  });
  it.each([
    ["a simulation that failed", { warning: "failed", failed: true, playing: false, converged: true }, true],
    ["a step that was given up", { warning: "stands still", playing: true, converged: false }, true],
    ["a step that was cut in pieces", { warning: "was cut in 4", playing: true, converged: true }, false],
    ["a pause after that", { warning: "was cut in 4", playing: false, converged: true }, false],
    ["no simulation", null, false],
  ])("offers a reset or not: %s", (_, simulation, offered) => {
    expect(wantsReset({ ...initialState, simulation: simulation as SimulationState | null })).toBe(offered);
  });
});

describe("what the hand does", () => {
  const mode = (patch: Partial<State>) =>
    modeOf({
      ...initialState,
      link: { status: "open" },
      hello: { capabilities: ["edit"] } as unknown as Hello,
      settings: { stiffness_parts: [] } as unknown as Settings,
      ...patch,
    })?.text;
  it("is said when it does not pull, and only while it can do it", () => {
    expect(mode({})).toBeUndefined();
    expect(mode({ tool: "stiffer" })).toMatch(/stiffer/);
    expect(mode({ tool: "pin" })).toMatch(/pinned/);
    expect(mode({ tool: "force", settings: {} as unknown as Settings })).toMatch(/force/);
    expect(mode({ tool: "force", hello: { capabilities: [] } as unknown as Hello })).toBeUndefined();
    expect(mode({ tool: "pin", pullsByKeys: true })).toMatch(/Arrow keys/);
    expect(mode({ tool: "stiffer", settings: {} as unknown as Settings })).toBeUndefined(); // an older server
    expect(mode({ tool: "pin", settings: {} as unknown as Settings })).toMatch(/pinned/);
    expect(mode({ tool: "pin", hello: { capabilities: [] } as unknown as Hello })).toBeUndefined(); // a recording
    expect(mode({ tool: "pin", scrub: 1 })).toBeUndefined();
    expect(mode({ tool: "pin", link: { status: "connecting" } })).toBeUndefined();
  });
});

describe("the cross in the middle", () => {
  const aims = (patch: Partial<State>) =>
    aimsAtMiddle({ ...initialState, link: { status: "open" }, hello: {} as Hello, ...patch });
  it("is there when keys mean what it is on", () => {
    expect(aims({})).toBe(true);
    expect(aims({ pointing: true })).toBe(false);
    expect(aims({ pullsByKeys: true })).toBe(false);
    expect(aims({ scrub: 1 })).toBe(false);
    expect(aims({ link: { status: "connecting" } })).toBe(false);
    expect(aims({ hello: { recording: { frames: 1, start: 0, end: 0 } } as unknown as Hello })).toBe(false);
  });
});

describe("throttle", () => {
  beforeEach(() => void vi.useFakeTimers());
  afterEach(() => void vi.useRealTimers());
  it("lets the first through at once and the last at the end", () => {
    const seen: number[] = [];
    const call = throttle(100, (x: number) => seen.push(x));
    [1, 2, 3].forEach((x) => call(x));
    expect(seen).toEqual([1]);
    vi.advanceTimersByTime(100);
    expect(seen).toEqual([1, 3]);
    vi.advanceTimersByTime(1000);
    call(4);
    expect(seen).toEqual([1, 3, 4]);
  });
});
