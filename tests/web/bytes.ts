// Messages of server/PROTOCOL.md made by hand, so that no test decodes what the code under test has encoded.
import { readFileSync } from "node:fs";

/** A golden file, see tests/golden/README.md. */
export const read = (name: string): ArrayBuffer => {
  const bytes = readFileSync(new URL(`../golden/${name}`, import.meta.url));
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
};

/** Always the same numbers 0..2^32-1 for a seed (xorshift32). */
export const random = (seed: number) => (): number => {
  seed ^= seed << 13;
  seed ^= seed >>> 17;
  seed ^= seed << 5;
  return (seed >>>= 0);
};

interface Header {
  type?: number;
  version?: number;
  generation?: number;
  epoch?: number;
  sequence?: number;
  time?: number;
  counts: [number, number, number];
}

export function message(header: Header, ...parts: ArrayBufferView[]): ArrayBuffer {
  const padded = parts.map((part) => Math.ceil(part.byteLength / 4) * 4);
  const bytes = new ArrayBuffer(32 + padded.reduce((a, b) => a + b, 0));
  const view = new DataView(bytes);
  view.setUint8(0, header.type ?? 1);
  view.setUint8(1, header.version ?? 1);
  view.setUint16(2, header.generation ?? 1, true);
  view.setUint32(4, header.epoch ?? 0, true);
  view.setUint32(8, header.sequence ?? 0, true);
  view.setUint32(12, header.counts[0], true);
  view.setFloat64(16, header.time ?? 0, true);
  view.setUint32(24, header.counts[1], true);
  view.setUint32(28, header.counts[2], true);
  let offset = 32;
  parts.forEach((part, i) => {
    new Uint8Array(bytes).set(new Uint8Array(part.buffer, part.byteOffset, part.byteLength), offset);
    offset += padded[i];
  });
  return bytes;
}

/** One triangle. */
export const model = (generation = 1): ArrayBuffer =>
  message({ type: 1, generation, counts: [3, 1, 0] }, Uint32Array.of(0, 1, 2), Float32Array.of(1e5, 2e5, 3e5));

/** Two front vertices, the edge between them, and a tet that is as flat as they are. */
export const topology = (epoch: number, generation = 1): ArrayBuffer =>
  message(
    { type: 2, generation, epoch, counts: [3, 1, 2] },
    Uint32Array.of(0, 1),
    Uint8Array.of(0, 1, 2),
    Uint8Array.of(1),
    Uint32Array.of(1, 0, 1, 0, 1),
    Uint8Array.of(2),
  );

/** Surface (x 0 0) (x+1 0 0) (x 1 0), front (x 0 0) (x+1 1 0). */
export const frame = (
  epoch: number,
  { sequence = 0, time = 0, generation = 1, x = 0, pulls = [] as number[] } = {},
): ArrayBuffer =>
  message(
    { type: 3, generation, epoch, sequence, time, counts: [3, 2, pulls.length / 7] },
    Float32Array.of(x, 0, 0, 1, 1, 0),
    Uint16Array.of(0, 0, 0, 65535, 0, 0, 0, 65535, 0),
    Uint16Array.of(0, 0, 0, 65535, 65535, 0),
    Float32Array.from(pulls),
  );

/** The frame of epoch 1, with values of the field with this number. */
export const colouredFrame = (field: number, high: number, typical: number, values: number[]): ArrayBuffer =>
  message(
    { type: 4, epoch: 1, counts: [3, 2, 0] },
    Float32Array.of(0, 0, 0, 1, 1, 0),
    Uint16Array.of(0, 0, 0, 65535, 0, 0, 0, 65535, 0),
    Uint16Array.of(0, 0, 0, 65535, 65535, 0),
    Uint32Array.of(field),
    Float32Array.of(high, typical),
    Uint16Array.from(values),
  );
