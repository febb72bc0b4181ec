// tetfront.v1's binary messages: pure decoding, no state, no I/O. messages.ts has the JSON ones.
// The contract is server/PROTOCOL.md; the golden bytes in tests/golden/ are read by this side and by the C++ side.
//
//     const message = decodeBinary(event.data);            // throws ProtocolError
//     if (message.kind === "frame") unpack(message.surface, message.low, message.extent, positions);

import { inflate } from "./inflate";
import { ProtocolError } from "./messages";
import type { FieldColouring, Vec3 } from "./messages";

export const HEADER_BYTES = 32;

interface Header {
  generation: number; // grows by 1 with each model, u16
  epoch: number; // of the topology
  sequence: number; // of the frame
  time: number; // [s] simulated
}

export interface Model extends Header {
  kind: "model";
  triangles: Uint32Array; // [F][3] into the surface vertices
  young: Float32Array; // [S] Pa
}

export interface Topology extends Header {
  kind: "topology";
  edges: Uint32Array; // [E][2] into the front's vertices
  surfaceLevel: Uint8Array; // [S]
  edgeLevel: Uint8Array; // [E]
  tets: Uint32Array; // [T][4] corners, into the front's vertices
  tetLevel: Uint8Array; // [T]
  frontVertices: number; // N
}

export interface Frame extends Header {
  kind: "frame";
  low: Vec3; // [m] box around all positions of this frame
  extent: Vec3; // [m]
  surface: Uint16Array; // [S][3], position = low + extent * u / 65535
  front: Uint16Array; // [N][3]
  pulls: Float32Array; // [P][7] grabbed point xyz, target xyz [m], force [N]
  values: FrameValues | null;
}

/** What a coloured frame has in addition. */
export interface FrameValues {
  field: FieldColouring;
  high: number; // the largest value, in the field's unit
  typical: number; // all but 2 % do not exceed it
  packed: Uint16Array; // [S], value = high * u / 65535
}

const FIELDS: readonly FieldColouring[] = ["displacement", "strain", "stress", "error"]; // numbers 1..4 on the wire

export type BinaryMessage = Model | Topology | Frame;

/** What a frame says of itself before any of it is read or unpacked: to whom it belongs, and its counts. Null: it is none. */
export function frameHead(
  bytes: ArrayBuffer,
): { generation: number; epoch: number; surface: number; front: number } | null {
  if (bytes.byteLength < HEADER_BYTES) return null;
  const view = new DataView(bytes);
  if (![3, 4, 5].includes(view.getUint8(0)) || view.getUint8(1) !== 1) return null;
  return {
    generation: view.getUint16(2, true),
    epoch: view.getUint32(4, true),
    surface: view.getUint32(12, true),
    front: view.getUint32(24, true),
  };
}

/** Reads one binary message; the arrays are views into one buffer, `bytes` unless it is compressed. Throws ProtocolError when anything does not fit. */
export function decodeBinary(bytes: ArrayBuffer): BinaryMessage {
  if (bytes.byteLength < HEADER_BYTES)
    throw new ProtocolError(`a binary message of ${bytes.byteLength} bytes is shorter than its header`);
  const view = new DataView(bytes);
  const version = view.getUint8(1);
  if (version !== 1) throw new ProtocolError(`a binary message has version ${version}, this page reads 1: reload it`);
  const header: Header = {
    generation: view.getUint16(2, true),
    epoch: view.getUint32(4, true),
    sequence: view.getUint32(8, true),
    time: view.getFloat64(16, true),
  };
  const a = view.getUint32(12, true);
  const b = view.getUint32(24, true);
  const c = view.getUint32(28, true);
  const take = new Cursor(bytes);
  let message: BinaryMessage;
  switch (view.getUint8(0)) {
    case 1:
      message = { kind: "model", ...header, triangles: take.u32(3 * b), young: take.f32(a) };
      checkIndices(message.triangles, a, "triangle");
      break;
    case 2:
      message = readTopology(header, take, a, b, c);
      break;
    case 3:
    case 4: {
      const box = take.f32(6);
      message = {
        kind: "frame",
        ...header,
        low: [box[0], box[1], box[2]],
        extent: [box[3], box[4], box[5]],
        surface: take.u16(3 * a),
        front: take.u16(3 * b),
        pulls: take.f32(7 * c),
        values: view.getUint8(0) === 4 ? readValues(take, a) : null,
      };
      break;
    }
    case 5:
      return decodeBinary(inflate(bytes));
    default:
      throw new ProtocolError(`a binary message has the unknown type ${view.getUint8(0)}`);
  }
  take.finish();
  return message;
}

function readTopology(
  header: Header,
  take: Cursor,
  surface: number,
  edgeCount: number,
  frontVertices: number,
): Topology {
  const edges = take.u32(2 * edgeCount);
  const surfaceLevel = take.u8(surface);
  const edgeLevel = take.u8(edgeCount);
  const [tetCount] = take.u32(1);
  const tets = take.u32(4 * tetCount);
  const tetLevel = take.u8(tetCount);
  checkIndices(edges, frontVertices, "edge");
  checkIndices(tets, frontVertices, "tet");
  return { kind: "topology", ...header, edges, surfaceLevel, edgeLevel, tets, tetLevel, frontVertices };
}

function readValues(take: Cursor, count: number): FrameValues {
  const [number] = take.u32(1);
  const field = FIELDS[number - 1] as FieldColouring | undefined;
  if (!field) throw new ProtocolError(`a frame has values of the unknown field ${number}`);
  const [high, typical] = take.f32(2);
  return { field, high, typical, packed: take.u16(count) };
}

/** out[i] = low + extent * packed[i] / 65535, for positions [n][3]. `out` is at least as long as `packed`. */
export function unpack(packed: Uint16Array, low: Vec3, extent: Vec3, out: Float32Array): void {
  const [lx, ly, lz] = low;
  const sx = extent[0] / 65535;
  const sy = extent[1] / 65535;
  const sz = extent[2] / 65535;
  for (let i = 0; i < packed.length; i += 3) {
    out[i] = lx + sx * packed[i];
    out[i + 1] = ly + sy * packed[i + 1];
    out[i + 2] = lz + sz * packed[i + 2];
  }
}

/** Hands out typed views one after the other; every array starts at a multiple of 4 bytes. */
class Cursor {
  private offset = HEADER_BYTES;
  constructor(private readonly bytes: ArrayBuffer) {}

  u8 = (length: number) => new Uint8Array(this.bytes, this.advance(length), length);
  u16 = (length: number) => new Uint16Array(this.bytes, this.advance(2 * length), length);
  u32 = (length: number) => new Uint32Array(this.bytes, this.advance(4 * length), length);
  f32 = (length: number) => new Float32Array(this.bytes, this.advance(4 * length), length);

  finish(): void {
    if (this.offset !== this.bytes.byteLength)
      throw new ProtocolError(`a binary message has ${this.bytes.byteLength} bytes, its counts need ${this.offset}`);
  }

  private advance(size: number): number {
    const start = this.offset;
    const end = start + Math.ceil(size / 4) * 4;
    if (end > this.bytes.byteLength)
      throw new ProtocolError(`a binary message has ${this.bytes.byteLength} bytes, its counts need at least ${end}`);
    this.offset = end;
    return start;
  }
}

function checkIndices(indices: Uint32Array, limit: number, what: string): void {
  for (let i = 0; i < indices.length; ++i)
    if (indices[i] >= limit) throw new ProtocolError(`${what} index ${indices[i]} is not below ${limit}`);
}
