import { readFileSync } from "node:fs";
import { MeshoptDecoder } from "meshoptimizer/meshopt_decoder_reference.js";
import { describe, expect, it, vi } from "vitest";

import { inflate } from "../../web/src/inflate";
import { ProtocolError } from "../../web/src/messages";
import { decodeBinary } from "../../web/src/protocol";
import { random, read } from "./bytes";

// The C++ test makes the same files.
describe.each(["frame", "coloured_frame"])("a compressed %s", (name) => {
  const compressed = read(`compressed_${name}_v1.bin`);

  it("becomes the plain one, byte for byte", () => {
    expect(Buffer.from(inflate(compressed))).toEqual(
      readFileSync(new URL(`../golden/${name}_v1.bin`, import.meta.url)),
    );
  });

  it("is decoded as such", () => {
    expect(decodeBinary(compressed)).toEqual(decodeBinary(read(`${name}_v1.bin`)));
  });

  it("is refused when anything is cut off", () => {
    for (let size = 0; size < compressed.byteLength; ++size)
      expect(() => decodeBinary(compressed.slice(0, size))).toThrow(ProtocolError);
  });

  it("is refused with counts that would need memory for nothing", () => {
    for (const at of [12, 24, 28])
      for (const count of [1000, 0x7fffffff, 0xffffffff]) {
        const bytes = compressed.slice(0);
        new DataView(bytes).setUint32(at, count, true);
        expect(() => decodeBinary(bytes)).toThrow(ProtocolError);
      }
  });

  it("does no harm when its streams are nonsense", () => {
    const next = random(1);
    for (let i = 0; i < 300; ++i) {
      const bytes = compressed.slice(0);
      const view = new Uint8Array(bytes);
      for (let k = 0; k < 4; ++k) view[104 + (next() % (view.length - 104))] = next();
      try {
        decodeBinary(bytes);
      } catch (error) {
        expect(error).toBeInstanceOf(ProtocolError);
      }
    }
  });
});

it("says of whatever the codec throws that the frame is broken", () => {
  const codec = vi.spyOn(MeshoptDecoder, "decodeVertexBuffer").mockImplementation(() => {
    throw new RangeError("offset is out of bounds");
  });
  expect(() => inflate(read("compressed_frame_v1.bin"))).toThrow(ProtocolError);
  codec.mockRestore();
  inflate(read("compressed_frame_v1.bin"));
});
