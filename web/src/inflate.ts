// Compressed frames: the same frame, its arrays packed with meshoptimizer's vertex codec, which halves what goes over a slow
// line. Pure; the layout is in server/PROTOCOL.md. What comes out is the plain message, byte for byte, so nothing else
// knows about compression.
//
//     const plain = inflate(event.data);            // throws ProtocolError
//
// The codec's decoder in plain JavaScript: WebAssembly would need a weaker content security policy.

import { MeshoptDecoder } from "meshoptimizer/meshopt_decoder_reference.js";

import { ProtocolError } from "./messages";

const HEADER = 32;
const BOX = 24; // bytes of low and extent
const PULL = 28; // bytes of a pull
const VERTEX = 8; // bytes of a vertex before it was packed: u16 x, y, z, value
const CODEC_VERSION = 0xa0; // first byte of a stream
const LONGEST_TAIL = 32; // bytes at the end of a stream

const padded = (size: number): number => Math.ceil(size / 4) * 4;

/** Bytes of a message of type 5 to those of type 3 or 4, up to 64 times as many: the link compares its counts with the model's
 * before. Throws ProtocolError when anything does not fit. */
export function inflate(bytes: ArrayBuffer): ArrayBuffer {
  const view = new DataView(bytes);
  const surface = view.getUint32(12, true);
  const front = view.getUint32(24, true);
  const pulls = view.getUint32(28, true);
  const values = HEADER + BOX + PULL * pulls; // field, high, typical, and the streams' lengths
  const streams = values + 20;
  if (streams > bytes.byteLength) throw tooShort(bytes, streams);
  const coloured = view.getUint32(values, true) !== 0;
  const surfaceBytes = view.getUint32(values + 12, true);
  const frontBytes = view.getUint32(values + 16, true);
  const end = streams + padded(surfaceBytes) + padded(frontBytes);
  if (end !== bytes.byteLength) throw tooShort(bytes, end);

  const surfaceVertices = unpackStream(new Uint8Array(bytes, streams, surfaceBytes), surface);
  const frontVertices = unpackStream(new Uint8Array(bytes, streams + padded(surfaceBytes), frontBytes), front);

  const frontAt = HEADER + BOX + padded(6 * surface);
  const pullsAt = frontAt + padded(6 * front);
  const valuesAt = pullsAt + PULL * pulls;
  const out = new ArrayBuffer(valuesAt + (coloured ? 12 + padded(2 * surface) : 0));
  const copy = (to: number, from: number, size: number) =>
    new Uint8Array(out, to, size).set(new Uint8Array(bytes, from, size));
  copy(0, 0, HEADER + BOX);
  new DataView(out).setUint8(0, coloured ? 4 : 3);
  copyPositions(surfaceVertices, new Uint16Array(out, HEADER + BOX, 3 * surface));
  copyPositions(frontVertices, new Uint16Array(out, frontAt, 3 * front));
  copy(pullsAt, HEADER + BOX, PULL * pulls);
  if (coloured) {
    copy(valuesAt, values, 12);
    const packed = new Uint16Array(out, valuesAt + 12, surface);
    for (let i = 0; i < surface; ++i) packed[i] = surfaceVertices[4 * i + 3];
  }
  return out;
}

function unpackStream(stream: Uint8Array, count: number): Uint16Array {
  // A stream spends 2 bits on 16 equal bytes at least, so a byte on 8 vertices: a larger count would be a reason to take memory for nothing.
  if (count > 8 * stream.length || (count > 0 && stream.length < 1 + LONGEST_TAIL))
    throw new ProtocolError(`a compressed frame has ${stream.length} bytes for ${count} vertices`);
  const vertices = new Uint16Array((VERTEX / 2) * count);
  if (count === 0) return vertices;
  if (stream[0] !== CODEC_VERSION)
    throw new ProtocolError(`a compressed frame begins with the unknown byte ${stream[0]}`);
  try {
    MeshoptDecoder.decodeVertexBuffer(new Uint8Array(vertices.buffer), count, VERTEX, stream);
  } catch (error) {
    throw new ProtocolError(`a compressed frame cannot be unpacked: ${String(error)}`);
  }
  return vertices;
}

function copyPositions(vertices: Uint16Array, out: Uint16Array): void {
  for (let i = 0, o = 0; o < out.length; i += 4) {
    out[o++] = vertices[i];
    out[o++] = vertices[i + 1];
    out[o++] = vertices[i + 2];
  }
}

const tooShort = (bytes: ArrayBuffer, needed: number) =>
  new ProtocolError(`a compressed frame has ${bytes.byteLength} bytes, its counts need ${needed}`);
