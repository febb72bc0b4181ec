import { beforeEach, describe, expect, it, vi } from "vitest";

import { Connection } from "../../web/src/connection";
import type { Port } from "../../web/src/connection";
import type { LinkEvent } from "../../web/src/link";
import { decodeBinary } from "../../web/src/protocol";
import type { Capability, Hello, Settings } from "../../web/src/messages";
import { colouringsOf, initialState, isOpen, Store } from "../../web/src/store";
import type { WorkerRequest } from "../../web/src/worker";
import { frame } from "./bytes";

let store: Store;
let port: Port & { requests: WorkerRequest[] };
let connection: Connection;
const events = { binary: vi.fn(), refused: vi.fn(), interrupted: vi.fn(), told: vi.fn() };
const emit = (event: LinkEvent) => port.onmessage?.({ data: event } as MessageEvent<LinkEvent>);
const hello = (name: string, playing = true, capabilities: Capability[] = []) =>
  emit({
    kind: "text",
    message: {
      ...({ type: "hello", protocol: 1, scene: { name, title: "" }, playing, capabilities } as unknown as Hello),
      view: { eye: [0, 0, 0], target: [0, 0, 0], field_of_view: 35, colouring: "stiffness", wireframe: true },
    },
  });

beforeEach(() => {
  vi.resetAllMocks();
  store = new Store({ ...initialState });
  port = { requests: [], onmessage: null, postMessage: (request) => port.requests.push(request) };
  connection = new Connection(port, store, events);
  emit({ kind: "link", link: { status: "open" } });
});

describe("Connection", () => {
  it("is usable after the hello only, that of each connection", () => {
    expect(isOpen(store.get())).toBe(false);
    hello("a");
    expect(isOpen(store.get())).toBe(true);
    port.requests = [];
    let openWhenInterrupted: boolean | null = null;
    events.interrupted.mockImplementation(() => (openWhenInterrupted = isOpen(store.get())));
    for (const status of ["connecting", "open"] as const) {
      emit({ kind: "link", link: { status } });
      expect([isOpen(store.get()), openWhenInterrupted]).toEqual([false, false]);
      openWhenInterrupted = null;
    }
    connection.send({ command: "reset" }); // the server may be another one by now
    expect(port.requests).toEqual([]);
    expect(events.refused).toHaveBeenCalledExactlyOnceWith({ command: "reset" }, "the server is not ready yet");
    hello("a");
    expect(isOpen(store.get())).toBe(true);
  });

  it("takes the view of a new scene, and keeps the user's for the same one", () => {
    hello("a");
    expect(store.get()).toMatchObject({ colouring: "stiffness", wireframe: true });
    store.set({ colouring: "level", wireframe: false, tool: "pin" });
    hello("a");
    expect(store.get()).toMatchObject({ colouring: "level", wireframe: false, tool: "pin" });
    hello("b");
    expect(store.get()).toMatchObject({ colouring: "stiffness", wireframe: true, tool: null });
  });

  it.each([
    ["ws://localhost:8080/ws", false],
    ["ws://127.0.0.1:8080/ws", false],
    ["ws://[::1]:8080/ws", false],
    ["wss://sim.example.org/ws", true],
    ["ws://192.168.1.7:8080/ws", true],
  ])("asks for compressed frames of a server on another machine: %s", (url, wanted) => {
    connection.connect(url);
    port.requests = [];
    hello("a", true, ["compress"]);
    expect(port.requests).toMatchObject(
      wanted ? [{ kind: "command", command: { command: "compression", value: true } }] : [],
    );
    port.requests = [];
    hello("b"); // an older server
    expect(port.requests).toEqual([]);
  });

  it("shows at first what a recording can show, and the scene's cut", () => {
    const view = { eye: [0, 0, 0], target: [0, 0, 0], field_of_view: 35, wireframe: true } as const;
    const cut = { point: [0, 0.5, 0], normal: [0, -2, 0] };
    const greet = (colouring: "stress" | "strain") =>
      emit({
        kind: "text",
        message: {
          ...({
            type: "hello",
            protocol: 1,
            rest_box: [0, 0, 0, 1, 2, 4],
            capabilities: ["colouring"],
          } as unknown as Hello),
          scene: { name: colouring, title: "" },
          recording: { frames: 1, start: 0, end: 1, colouring: "strain" },
          view: { ...view, colouring, cut },
        },
      });
    greet("stress");
    expect(store.get()).toMatchObject({ colouring: "level", cut: { axis: 1, at: 0.25, flip: true } });
    expect(colouringsOf(store.get().hello).map(({ value }) => value)).toEqual(["level", "stiffness", "strain"]);
    greet("strain");
    expect(store.get().colouring).toBe("strain");
  });

  it("numbers commands and tells which one was refused, and where", () => {
    hello("a");
    connection.send({ command: "play" });
    connection.send({ command: "tolerance", value: 3 });
    expect(port.requests).toMatchObject([{ id: 1 }, { id: 2 }]);
    const refusal = { type: "error", code: "out_of_range", pointer: "/value", message: "is 3; use 0..1" } as const;
    emit({ kind: "text", message: { type: "ok", id: 1 } });
    emit({ kind: "text", message: { ...refusal, id: 2 } });
    expect(events.refused).toHaveBeenCalledExactlyOnceWith({ command: "tolerance", value: 3 }, "value is 3; use 0..1");
    emit({ kind: "text", message: { ...refusal, id: null, pointer: "" } });
    expect(events.refused).toHaveBeenLastCalledWith(null, "is 3; use 0..1");
  });

  it("does not send without a connection, and says so", () => {
    emit({ kind: "link", link: { status: "connecting" } });
    connection.send({ command: "play" });
    expect(port.requests).toEqual([]);
    expect(events.refused).toHaveBeenCalledOnce();
  });

  it("forgets the numbers, but not the scene, when the connection is lost", () => {
    hello("a");
    store.set({ progress: { type: "progress", what: "", fraction: 0.5 } });
    emit({ kind: "link", link: { status: "waiting", until: 0, attempt: 1, reason: "" } });
    expect(store.get()).toMatchObject({ simulation: null, progress: null, hello: { scene: { name: "a" } } });
    expect(events.interrupted).toHaveBeenCalledTimes(2); // when it opened, when it closed
  });

  it("asks for the next frame when it has one, and counts what was skipped", () => {
    emit({ kind: "binary", message: decodeBinary(frame(1)), dropped: 2 });
    expect(events.binary).toHaveBeenCalledOnce();
    expect(port.requests).toEqual([{ kind: "ready" }]);
    expect(store.get().framesDropped).toBe(2);
    connection.drawn(7); // later, and never in a tab that nobody sees
    expect(port.requests.at(-1)).toEqual({ kind: "drawn", sequence: 7 });
  });

  it("blames no network for frames that a hidden page did not want", () => {
    const report = { type: "link", sent: 2, dropped: 90, unacknowledged: 2, round_trip: null } as const;
    connection.hidden = true;
    emit({ kind: "text", message: report });
    expect(store.get().linkReport).toBeNull();
    connection.hidden = false;
    emit({ kind: "text", message: report });
    expect(store.get().linkReport).toEqual(report);
  });

  it("shows progress until it is done", () => {
    emit({ kind: "text", message: { type: "progress", what: "tree", fraction: 0.4 } });
    expect(store.get().progress?.what).toBe("tree");
    emit({ kind: "text", message: { type: "progress", what: "tree", fraction: 1 } });
    expect(store.get().progress).toBeNull();
  });
});

describe("Store.watch", () => {
  it("reacts at once, then on changes of its part only, until stopped", () => {
    const seen: boolean[] = [];
    const stop = store.watch(
      (s) => s.wireframe,
      (on) => seen.push(on),
    );
    store.set({ dark: true });
    store.set({ wireframe: true });
    stop();
    store.set({ wireframe: false });
    expect(seen).toEqual([false, true]);
  });

  it("hands answers to who asked, and null when there is none", async () => {
    hello("a");
    const scenes = connection.request({ command: "scenes" });
    emit({ kind: "text", message: { type: "ok", id: 1, scenes: [{ name: "box", title: "Box" }] } });
    expect((await scenes)?.scenes).toEqual([{ name: "box", title: "Box" }]);
    const load = connection.request({ command: "load", scene: "nothing" });
    emit({
      kind: "text",
      message: { type: "error", id: 2, code: "unknown_name", pointer: "/scene", message: "is not there" },
    });
    expect(await load).toBeNull();
    expect(events.refused).toHaveBeenCalledWith({ command: "load", scene: "nothing" }, "scene is not there");
    const lost = connection.request({ command: "recordings" });
    emit({ kind: "link", link: { status: "connecting" } });
    expect(await lost).toBeNull();
  });

  it("starts over with another scene", () => {
    const settings = (order: number): Settings => ({
      ...{ type: "settings" as const, order, stiffness_scale: 1, damping: { mass: 0, stiffness: 0 } },
      ...{ budget: { tets: null, milliseconds: null }, forces: [], pins: [] },
    });
    hello("a");
    emit({ kind: "text", message: settings(2) });
    emit({ kind: "text", message: settings(1) });
    expect(store.get()).toMatchObject({ settings: { order: 1 } });
    events.interrupted.mockClear();
    hello("b");
    expect(store.get()).toMatchObject({ settings: null });
    expect(events.interrupted).toHaveBeenCalledOnce();
  });

  it("passes on what all should know", () => {
    emit({ kind: "text", message: { type: "log", level: "info", message: "Somebody opened the box." } });
    expect(events.told).toHaveBeenCalledExactlyOnceWith("Somebody opened the box.");
  });
});
