import { readFileSync } from "node:fs";
import { MeshoptDecoder } from "meshoptimizer/meshopt_decoder_reference.js";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { backoff, transferOf } from "../../web/src/link";
import type { Link, LinkEvent } from "../../web/src/link";
import { decodeBinary } from "../../web/src/protocol";
import { frame, message, model, topology } from "./bytes";
import { falseLink, FalseSocket, hello, socket, statuses } from "./false_socket";

let events: LinkEvent[];
let link: Link;
const links = () => statuses(events);
const shown = () =>
  events.flatMap((event) => (event.kind === "binary" ? [`${event.message.kind} ${event.message.sequence}`] : []));
const frames = () => shown().filter((name) => name.startsWith("frame"));

beforeEach(() => ({ link, events } = falseLink()));
afterEach(() => vi.useRealTimers());

describe("connecting", () => {
  it("offers the subprotocol and reports each state", () => {
    expect(socket()).toMatchObject({ url: "ws://host/ws", protocol: "tetfront.v1", binaryType: "arraybuffer" });
    socket().open();
    expect(links()).toEqual(["connecting", "open"]);
  });

  it("comes back by itself, later and later, and soon again after a success", () => {
    const waits: number[] = [];
    for (let i = 0; i < 6; ++i) {
      const before = FalseSocket.all.length;
      socket().close();
      const event = events.at(-1)!;
      if (event.kind !== "link" || event.link.status !== "waiting") throw new Error();
      waits.push(event.link.until - Date.now());
      vi.advanceTimersByTime(waits[i] - 1);
      expect(FalseSocket.all.length).toBe(before);
      vi.advanceTimersByTime(1);
      expect(FalseSocket.all.length).toBe(before + 1);
    }
    expect(waits).toEqual([500, 1000, 2000, 4000, 8000, 10000]);
    socket().open();
    socket().receive(JSON.stringify(hello));
    socket().close();
    expect(events.at(-1)).toMatchObject({ link: { status: "waiting", attempt: 1 } });
    expect(backoff(1)).toBe(500);
  });

  it("gives up on a server that does not answer, and tries again", () => {
    vi.advanceTimersByTime(8000);
    expect(links()).toEqual(["connecting", "waiting"]);
  });

  it("says why a server turns it away", () => {
    socket().open();
    socket().close(1013, "there are too many clients");
    expect(events.at(-1)).toMatchObject({ link: { status: "waiting", reason: "there are too many clients" } });
    vi.advanceTimersByTime(500);
    socket().close();
    expect(events.at(-1)).toMatchObject({ link: { status: "waiting", reason: "" } });
  });

  it("tries at once when asked to, and only once", () => {
    socket().close();
    link.connect();
    link.connect();
    vi.advanceTimersByTime(1000);
    expect(FalseSocket.all.length).toBe(2);
  });

  it("stops at a server that breaks the protocol, and says why", () => {
    socket().open();
    socket().receive(new ArrayBuffer(3));
    expect(events.at(-1)).toMatchObject({
      link: { status: "incompatible", reason: expect.stringContaining("3 bytes") },
    });
    vi.advanceTimersByTime(60_000);
    expect(FalseSocket.all.length).toBe(1);
  });
});

describe("commands", () => {
  it("go out while the connection is open, and are not kept for later", () => {
    expect(link.send(1, { command: "play" })).toBe(false);
    socket().open();
    expect(link.send(2, { command: "pause" })).toBe(true);
    expect(socket().sent).toEqual(['{"id":2,"command":"pause"}']);
  });
});

describe("frames", () => {
  beforeEach(() => {
    socket().open();
    socket().receive(model(), topology(1));
  });

  it("wait for the page, and only the newest does", () => {
    socket().receive(frame(1, { sequence: 1 }), frame(1, { sequence: 2 }), frame(1, { sequence: 3 }));
    expect(frames()).toEqual(["frame 1"]);
    link.ready();
    expect(frames()).toEqual(["frame 1", "frame 3"]);
    expect(events.at(-1)).toMatchObject({ dropped: 1 });
    link.ready();
    expect(frames()).toEqual(["frame 1", "frame 3"]);
    socket().receive(frame(1, { sequence: 4 }));
    expect(frames().at(-1)).toBe("frame 4");
  });

  it("of another epoch or generation never pass", () => {
    socket().receive(frame(2, { sequence: 1 }), frame(1, { sequence: 2, generation: 2 }));
    expect(frames()).toEqual([]);
    socket().receive(topology(2), frame(1, { sequence: 3 }), frame(2, { sequence: 4 }));
    expect(frames()).toEqual(["frame 4"]);
  });

  it("that wait are dropped when the topology changes", () => {
    socket().receive(frame(1, { sequence: 1 }), frame(1, { sequence: 2 }), topology(2));
    link.ready();
    expect(frames()).toEqual(["frame 1"]);
    socket().receive(frame(2, { sequence: 3 }));
    expect(frames()).toEqual(["frame 1", "frame 3"]);
  });

  it("of the last connection do not pass in the next one", () => {
    socket().close();
    vi.advanceTimersByTime(500);
    socket().open();
    socket().receive(topology(1), frame(1, { sequence: 9 }));
    expect(shown()).toEqual(["model 0", "topology 0"]);
  });

  it("with other counts than their model's break the protocol", () => {
    const bytes = frame(1);
    new DataView(bytes).setUint32(12, 2, true); // 2 surface vertices take 12 bytes, 3 take 18 + 2
    new DataView(bytes).setUint32(24, 3, true); // 3 front vertices take 20, 2 take 12
    socket().receive(bytes);
    expect(events.at(-1)).toMatchObject({
      link: { status: "incompatible", reason: expect.stringMatching(/2 surface/) },
    });
  });

  it("are not unpacked when their counts are not their model's", () => {
    const codec = vi.spyOn(MeshoptDecoder, "decodeVertexBuffer");
    // All zeros is a stream that the codec takes, for eight vertices a byte.
    const stream = new Uint8Array(1000);
    stream[0] = 0xa0;
    const lengths = Uint32Array.of(0, 0, 0, stream.length, 0);
    const bomb = (surface: number) =>
      message({ type: 5, epoch: 1, counts: [surface, 0, 0] }, new Float32Array(6), lengths, stream);
    expect(decodeBinary(bomb(8000))).toMatchObject({ kind: "frame" });
    expect(codec).toHaveBeenCalledTimes(1);
    socket().receive(bomb(8000));
    expect(codec).toHaveBeenCalledTimes(1);
    expect(events.at(-1)).toMatchObject({
      link: { status: "incompatible", reason: expect.stringMatching(/8000 surface .* not 3/) },
    });
    codec.mockRestore();
  });

  it("are transferred, not copied", () => {
    socket().receive(frame(1));
    const event = events.at(-1)!;
    if (event.kind !== "binary" || event.message.kind !== "frame") throw new Error();
    expect(transferOf(event)).toEqual([event.message.pulls.buffer]);
  });
});

describe("what newer servers ask for", () => {
  const capable = JSON.parse(readFileSync(new URL("../golden/hello_v1.json", import.meta.url), "utf8"));
  const acknowledged = () =>
    socket()
      .sent.map((text) => JSON.parse(text))
      .filter(({ command }) => command === "ack");

  const numbered = (...sequences: number[]) => sequences.map((sequence) => ({ command: "ack", frame: sequence }));

  it.each([
    [["acknowledge"], [numbered(1), numbered(1), numbered(1, 2)]],
    [[], [[], [], []]],
  ])("acknowledges the first frame, and then those that were drawn, when the server has %j", (capabilities, wanted) => {
    socket().open();
    socket().receive(JSON.stringify({ ...capable, capabilities }), model(), topology(1), frame(1, { sequence: 1 }));
    expect(acknowledged()).toEqual(wanted[0]);
    link.ready();
    socket().receive(frame(1, { sequence: 2 }), frame(1, { sequence: 3 }));
    link.ready();
    expect(acknowledged()).toEqual(wanted[1]); // nobody sees the page
    link.drawn(2);
    link.drawn(99); // of an earlier connection
    expect(acknowledged()).toEqual(wanted[2]);
  });

  it("waits for a token when the server wants one", () => {
    socket().open();
    socket().close(4001);
    expect(links().at(-1)).toBe("locked");
    vi.advanceTimersByTime(60_000);
    expect(FalseSocket.all.length).toBe(1);
    link.connect();
    expect(FalseSocket.all.length).toBe(2);
  });

  it("gives up on a server of another version, and says why", () => {
    socket().open();
    socket().close(1002, "this server speaks tetfront.v3");
    expect(events.at(-1)).toEqual({
      kind: "link",
      link: { status: "incompatible", reason: "this server speaks tetfront.v3: reload the page" },
    });
    vi.advanceTimersByTime(60_000);
    expect(FalseSocket.all.length).toBe(1);
  });
});
