import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import type { Link, LinkEvent } from "../../web/src/link";
import { falseLink, FalseSocket, hello, socket, statuses } from "./false_socket";

let events: LinkEvent[];
let link: Link;
const links = () => statuses(events);

beforeEach(() => ({ link, events } = falseLink()));
afterEach(() => vi.useRealTimers());

describe("a dead network", () => {
  const state = (playing: boolean) =>
    JSON.stringify({
      ...{ type: "state", playing, speed: 1, time: 0, step: 0, steps_per_second: 60, tets_by_level: [1] },
      ...{ free_vertices: 1, estimate: 0, tolerance: 0.1, gravity: [0, 0, 0], milliseconds: 1, iterations: 1 },
      ...{ converged: true, viewers: 1, warning: "" },
    });
  const start = (playing: boolean) => {
    socket().open();
    socket().receive(JSON.stringify({ ...hello, playing }));
  };

  it("is noticed while a simulation plays, though it closes nothing", () => {
    start(true);
    for (let i = 0; i < 20; ++i) {
      vi.advanceTimersByTime(1000);
      socket().receive(state(true));
    }
    expect(socket().sent).toEqual([]);
    const first = socket();
    vi.advanceTimersByTime(6000);
    expect(first.sent).toEqual(['{"id":0,"command":"scenes"}']);
    expect(links().filter((status) => status === "waiting").length).toBe(1);
    expect(FalseSocket.all.length).toBe(2); // it tries again
    first.receive(state(true)); // too late
    expect(events.at(-1)?.kind).toBe("link");
  });

  it("is not seen in a simulation that takes long for its steps", () => {
    start(true);
    for (let i = 0; i < 10; ++i) {
      vi.advanceTimersByTime(3000);
      socket().receive('{"type":"ok","id":0,"scenes":[]}'); // the page did not ask
    }
    expect(links()).toEqual(["connecting", "open"]);
    expect(events.filter((event) => event.kind === "text").length).toBe(1);
  });

  it("is not looked for while nothing is to come, but when an answer is", () => {
    start(true);
    socket().receive(state(false));
    vi.advanceTimersByTime(60_000);
    link.send(1, { command: "play" });
    vi.advanceTimersByTime(1000);
    socket().receive('{"type":"ok","id":1}');
    vi.advanceTimersByTime(60_000);
    expect(links()).toEqual(["connecting", "open"]);
    expect(socket().sent.length).toBe(1);
    link.send(2, { command: "play" });
    vi.advanceTimersByTime(4000);
    expect(links().at(-1)).toBe("open");
    vi.advanceTimersByTime(1500);
    expect(links().slice(0, 3)).toEqual(["connecting", "open", "waiting"]);
  });
});
