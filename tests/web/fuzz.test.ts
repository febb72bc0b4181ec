// Random bytes instead of messages: the decoder says ProtocolError, or gives arrays as long as its counts; never anything else.
// Always the same bytes, so that a failure can be repeated.
import { describe, expect, it } from "vitest";

import { parseText, ProtocolError } from "../../web/src/messages";
import { decodeBinary } from "../../web/src/protocol";
import { random, read } from "./bytes";

const names = ["model", "topology", "frame", "coloured_frame", "compressed_frame", "compressed_coloured_frame"];

/** Decodes, and checks what came out. True: it was a message. */
function survives(bytes: ArrayBuffer): boolean {
  let message;
  try {
    message = decodeBinary(bytes);
  } catch (error) {
    expect(error).toBeInstanceOf(ProtocolError);
    return false;
  }
  const below = (indices: Uint32Array, limit: number) => indices.every((i) => i < limit);
  if (message.kind === "model") expect(below(message.triangles, message.young.length)).toBe(true);
  else if (message.kind === "topology") {
    expect(below(message.edges, message.frontVertices)).toBe(true);
    expect(message.edgeLevel.length).toBe(message.edges.length / 2);
  } else {
    expect(message.surface.length % 3).toBe(0);
    expect(message.front.length % 3).toBe(0);
    expect(message.pulls.length % 7).toBe(0);
    if (message.values) expect(message.values.packed.length).toBe(message.surface.length / 3);
  }
  return true;
}

describe("decodeBinary", () => {
  it.each(names)("survives mutations of a %s", (name) => {
    const original = new Uint8Array(read(`${name}_v1.bin`));
    const next = random(names.indexOf(name) + 1);
    let whole = 0;
    for (let i = 0; i < 3000; ++i) {
      // Cut or made longer now and then, and a few bytes replaced: often by the small numbers that counts are.
      const size = next() % 8 === 0 ? next() % (2 * original.length) : original.length;
      const bytes = new Uint8Array(size);
      bytes.set(original.subarray(0, size));
      for (let k = next() % 4; k > 0 && size > 0; --k)
        bytes[next() % (next() % 2 ? Math.min(size, 64) : size)] = next() % 2 ? next() % 8 : next();
      if (survives(bytes.buffer)) ++whole;
    }
    expect(whole, "mutations that were messages still").toBeGreaterThan(100);
  });

  it("survives bytes of no meaning", () => {
    const next = random(99);
    for (let i = 0; i < 3000; ++i) {
      const bytes = Uint8Array.from({ length: next() % 200 }, () => next());
      if (bytes.length > 1) bytes.set([next() % 6, 1]); // a type and the version, or all would be refused at once
      survives(bytes.buffer);
    }
  });
});

describe("parseText", () => {
  it("survives mutations of a hello", () => {
    const original = Buffer.from(read("hello_v1.json"));
    const next = random(7);
    for (let i = 0; i < 3000; ++i) {
      const bytes = Buffer.from(original);
      for (let k = next() % 5; k > 0; --k) bytes[next() % bytes.length] = next();
      try {
        parseText(bytes.toString("utf8"));
      } catch (error) {
        expect(error).toBeInstanceOf(ProtocolError);
      }
    }
  });
});
