import { existsSync, readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";

import { encodeCommand, parseText, ProtocolError } from "../../web/src/messages";
import { decodeBinary, unpack } from "../../web/src/protocol";
import { colouredFrame, frame, message, model, read, topology } from "./bytes";

const golden = new URL("../golden/", import.meta.url);

describe("decodeBinary", () => {
  it("reads a model", () => {
    const decoded = decodeBinary(model(7));
    expect(decoded).toMatchObject({ kind: "model", generation: 7, epoch: 0 });
    if (decoded.kind !== "model") throw new Error();
    expect([...decoded.triangles]).toEqual([0, 1, 2]);
    expect([...decoded.young]).toEqual([1e5, 2e5, 3e5]);
  });

  it("reads a topology, whose byte arrays are padded", () => {
    const decoded = decodeBinary(topology(9));
    if (decoded.kind !== "topology") throw new Error();
    expect(decoded).toMatchObject({ epoch: 9, frontVertices: 2 });
    expect([...decoded.edges]).toEqual([0, 1]);
    expect([...decoded.surfaceLevel]).toEqual([0, 1, 2]);
    expect([...decoded.edgeLevel]).toEqual([1]);
  });

  it("reads a frame with pulls", () => {
    const decoded = decodeBinary(frame(4, { sequence: 12, time: 0.25, x: 2, pulls: [1, 2, 3, 4, 5, 6, 7.5] }));
    if (decoded.kind !== "frame") throw new Error();
    expect(decoded).toMatchObject({ epoch: 4, sequence: 12, time: 0.25, low: [2, 0, 0], extent: [1, 1, 0] });
    expect([...decoded.pulls]).toEqual([1, 2, 3, 4, 5, 6, 7.5]);
    const positions = new Float32Array(9);
    unpack(decoded.surface, decoded.low, decoded.extent, positions);
    expect([...positions]).toEqual([2, 0, 0, 3, 0, 0, 2, 1, 0]);
  });

  it("reads a coloured frame", () => {
    const decoded = decodeBinary(colouredFrame(3, 20, 10, [0, 65535, 32768]));
    if (decoded.kind !== "frame") throw new Error();
    expect(decoded.values).toMatchObject({ field: "stress", high: 20, typical: 10 });
    expect([...decoded.values!.packed]).toEqual([0, 65535, 32768]);
    expect(() => decodeBinary(colouredFrame(9, 1, 1, [0, 0, 0]))).toThrow(ProtocolError);
  });

  it.each([
    ["shorter than its header", new ArrayBuffer(31)],
    ["a newer version", message({ version: 2, counts: [0, 0, 0] })],
    ["an unknown type", message({ type: 9, counts: [0, 0, 0] })],
    ["counts beyond its end", message({ type: 1, counts: [3, 1, 0] }, Uint32Array.of(0, 1, 2))],
    ["bytes beyond its counts", message({ type: 1, counts: [0, 0, 0] }, Uint32Array.of(0))],
    ["counts whose size overflows 32 bits", message({ type: 1, counts: [0, 0xffffffff, 0] })],
    [
      "a triangle without its vertex",
      message({ type: 1, counts: [1, 1, 0] }, Uint32Array.of(0, 0, 1), Float32Array.of(1)),
    ],
    [
      "an edge without its vertex",
      message({ type: 2, counts: [0, 1, 1] }, Uint32Array.of(0, 1), Uint8Array.of(0), Uint32Array.of(0)),
    ],
    [
      "a tet without its vertex",
      message({ type: 2, counts: [0, 0, 3] }, Uint32Array.of(1, 0, 1, 2, 3), Uint8Array.of(0)),
    ],
    ["more tets than there are bytes", message({ type: 2, counts: [0, 0, 3] }, Uint32Array.of(2 ** 31, 0, 1, 2, 0))],
  ])("refuses %s", (_, bytes) => expect(() => decodeBinary(bytes)).toThrow(ProtocolError));

  it("refuses every truncation of a good frame", () => {
    const bytes = frame(1, { pulls: [0, 0, 0, 0, 0, 0, 0] });
    for (let size = 0; size < bytes.byteLength; ++size)
      expect(() => decodeBinary(bytes.slice(0, size))).toThrow(ProtocolError);
  });
});

// The values are those of tests/golden/README.md; the C++ test writes and reads the same files.
describe.skipIf(!existsSync(new URL("frame_v1.bin", golden)))("the golden bytes", () => {
  it("are a model", () => {
    const decoded = decodeBinary(read("model_v1.bin"));
    if (decoded.kind !== "model") throw new Error();
    expect(decoded.generation).toBe(1);
    expect([...decoded.triangles]).toEqual([0, 1, 2, 2, 3, 4]);
    expect([...decoded.young]).toEqual([1e4, 2e4, 3e4, 4e4, 5e4]);
  });

  it("are a topology", () => {
    const decoded = decodeBinary(read("topology_v1.bin"));
    if (decoded.kind !== "topology") throw new Error();
    expect(decoded).toMatchObject({ generation: 1, epoch: 7, frontVertices: 3 });
    expect([...decoded.surfaceLevel]).toEqual([0, 1, 2, 1, 0]);
    expect([...decoded.edges]).toEqual([0, 1, 1, 2, 0, 2]);
    expect([...decoded.edgeLevel]).toEqual([0, 1, 2]);
    expect([...decoded.tets]).toEqual([0, 1, 2, 0, 2, 1, 0, 2]);
    expect([...decoded.tetLevel]).toEqual([1, 2]);
  });

  it("are a frame", () => {
    const decoded = decodeBinary(read("frame_v1.bin"));
    if (decoded.kind !== "frame") throw new Error();
    expect(decoded).toMatchObject({
      generation: 1,
      epoch: 7,
      sequence: 42,
      time: 1.25,
      low: [-1, 0, 5],
      extent: [4, 8, 0],
    });
    const expectPositions = (packed: Uint16Array, wanted: number[]) => {
      const positions = new Float32Array(packed.length);
      unpack(packed, decoded.low, decoded.extent, positions);
      positions.forEach((x, i) => expect(Math.abs(x - wanted[i])).toBeLessThan(8 / 65535));
      expect(positions.length).toBe(wanted.length);
    };
    expectPositions(decoded.surface, [-1, 0, 5, 3, 8, 5, 1, 4, 5, 0, 2, 5, 2, 6, 5]);
    expectPositions(decoded.front, [-1, 0, 5, 3, 0, 5, 3, 8, 5]);
    expect([...decoded.pulls]).toEqual([1, 4, 5, 1.5, 4.25, 6, 12.5]);
  });

  it.each(["hello", "state"])("come with a %s that this side understands", (type) => {
    expect(parseText(readFileSync(new URL(`${type}_v1.json`, golden), "utf8"))).toMatchObject({ type });
  });
});

describe("parseText", () => {
  it("reads what it knows and ignores types of newer servers", () => {
    expect(parseText('{"type":"progress","what":"tree","fraction":0.5}')).toMatchObject({ what: "tree" });
    expect(parseText('{"type":"weather","sun":true}')).toBeNull();
    expect(parseText('{"type":"toString"}')).toBeNull();
  });

  it.each([
    "",
    "{",
    "[]",
    "null",
    "7",
    '{"kind":"state"}',
    '{"type":"progress","what":"tree"}',
    '{"type":"hello","protocol":1}',
  ])("refuses %s", (text) => expect(() => parseText(text)).toThrow(ProtocolError));

  it("says what to do about another protocol, even when nothing else of the hello is known", () => {
    expect(() => parseText('{"type":"hello","protocol":2}')).toThrow(/speaks protocol 2, this page 1: reload/);
  });
});

describe("encodeCommand", () => {
  it("puts the id beside the command's keys", () => {
    const text = encodeCommand(3, { command: "pull_move", pull: 1, target: [1, 2, 3] });
    expect(JSON.parse(text)).toEqual({ id: 3, command: "pull_move", pull: 1, target: [1, 2, 3] });
  });

  it.each([NaN, Infinity])("refuses %d, which JSON would turn into null", (value) => {
    expect(() => encodeCommand(1, { command: "gravity", value: [0, value, 0] })).toThrow(RangeError);
  });
});
