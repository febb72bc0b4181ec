// tetfront.v1 as bytes and JSON: pure decoding and encoding, no state, no I/O, no imports.
// The contract is server/PROTOCOL.md; the golden bytes in tests/golden/ are read by this side and by the C++ side.
//
//     const message = decodeBinary(event.data);            // throws ProtocolError
//     if (message.kind === "frame") unpack(message.surface, message.low, message.extent, positions);

export const SUBPROTOCOL = "tetfront.v1";
export const PROTOCOL = 1;
export const HEADER_BYTES = 32;

export type Vec3 = readonly [number, number, number];
export type Colouring = "level" | "stiffness";

/** A message that does not follow the protocol; the connection cannot be trusted any more. */
export class ProtocolError extends Error {
  override name = "ProtocolError";
}

// ---------------------------------------------------------------- server to client, JSON

export interface Hello {
  type: "hello";
  protocol: number;
  version: string;
  scene: { name: string; title: string };
  up: 0 | 1 | 2;
  depth: number; // levels are 0..depth
  young_range: readonly [number, number]; // [Pa]
  rest_box: readonly number[]; // [m] low xyz, high xyz
  view: {
    eye: Vec3;
    target: Vec3;
    field_of_view: number /* degrees, vertical */;
    colouring: Colouring;
    wireframe: boolean;
  };
  gravity: Vec3; // [m/s²]
  tolerance: number;
  time_step: number; // [s]
  order: number;
  playing: boolean;
  speed: number; // simulated seconds per real second
  limits: { message_bytes: number };
}

export interface SimulationState {
  type: "state";
  playing: boolean;
  speed: number;
  time: number; // [s]
  step: number;
  steps_per_second: number;
  tets_by_level: readonly number[]; // [depth+1]
  free_vertices: number;
  estimate: number; // relative displacement error
  tolerance: number;
  gravity: Vec3;
  milliseconds: number; // last step
  iterations: number;
  converged: boolean;
  viewers: number;
  warning: string; // "" or one line
}

export interface Progress {
  type: "progress";
  what: string;
  fraction: number; // 0..1
  remaining?: number | null; // [s]
}

export interface Answer {
  type: "ok";
  id: number;
}

export interface Refusal {
  type: "error";
  id: number | null;
  code: string;
  pointer: string;
  message: string;
}

export type TextMessage = Hello | SimulationState | Progress | Answer | Refusal;

const REQUIRED: Record<TextMessage["type"], readonly string[]> = {
  hello: [
    ...["protocol", "version", "scene", "up", "depth", "young_range", "rest_box", "view", "gravity", "tolerance"],
    ...["time_step", "order", "playing", "speed", "limits"],
  ],
  state: [
    ...["playing", "speed", "time", "step", "steps_per_second", "tets_by_level", "free_vertices", "estimate"],
    ...["tolerance", "gravity", "milliseconds", "iterations", "converged", "viewers", "warning"],
  ],
  progress: ["what", "fraction"],
  ok: ["id"],
  error: ["id", "code", "message"],
};

/** Unknown keys are welcome (a newer server), unknown types give null; missing keys throw ProtocolError. */
export function parseText(text: string): TextMessage | null {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    throw new ProtocolError(`the server sent text that is not JSON: ${text.slice(0, 60)}`);
  }
  if (typeof value !== "object" || value === null || Array.isArray(value))
    throw new ProtocolError("the server sent JSON that is not an object");
  const message = value as Record<string, unknown>;
  const type = message["type"];
  if (typeof type !== "string") throw new ProtocolError("the server sent a message without a type");
  if (!Object.hasOwn(REQUIRED, type)) return null;
  const required = REQUIRED[type as TextMessage["type"]];
  // The version is read first: a newer hello may well look different.
  if (type === "hello" && message["protocol"] !== PROTOCOL)
    throw new ProtocolError(
      `the server speaks protocol ${String(message["protocol"])}, this page ${PROTOCOL}: reload the page`,
    );
  for (const key of required)
    if (message[key] === undefined) throw new ProtocolError(`the server's "${type}" message lacks "${key}"`);
  return message as unknown as TextMessage;
}

// ---------------------------------------------------------------- client to server, JSON

export type Command =
  | { command: "play" | "pause" | "reset" }
  | { command: "step"; count?: number } // 1..1000, while paused
  | { command: "speed"; value: number } // 0.01..10
  | { command: "pull_begin"; pull: number; triangle: number; barycentric: Vec3; target: Vec3 }
  | { command: "pull_move"; pull: number; target: Vec3 }
  | { command: "pull_end"; pull: number }
  | { command: "gravity"; value: Vec3 } // [m/s²]
  | { command: "tolerance"; value: number }; // 1e-6..1

/** One text message. JSON has no NaN or infinity, so such a number is refused here, where it was made. */
export function encodeCommand(id: number, command: Command): string {
  return JSON.stringify({ id, ...command }, (key, value: unknown) => {
    if (typeof value === "number" && !Number.isFinite(value))
      throw new RangeError(`${command.command}: ${key} is not a finite number`);
    return value;
  });
}

// ---------------------------------------------------------------- server to client, binary

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
  frontVertices: number; // N
}

export interface Frame extends Header {
  kind: "frame";
  low: Vec3; // [m] box around all positions of this frame
  extent: Vec3; // [m]
  surface: Uint16Array; // [S][3], position = low + extent * u / 65535
  front: Uint16Array; // [N][3]
  pulls: Float32Array; // [P][7] grabbed point xyz, target xyz [m], force [N]
}

export type BinaryMessage = Model | Topology | Frame;

/** Reads one binary message; the arrays are views into `bytes`. Throws ProtocolError when anything does not fit. */
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
      message = {
        kind: "topology",
        ...header,
        edges: take.u32(2 * b),
        surfaceLevel: take.u8(a),
        edgeLevel: take.u8(b),
        frontVertices: c,
      };
      checkIndices(message.edges, c, "edge");
      break;
    case 3: {
      const box = take.f32(6);
      message = {
        kind: "frame",
        ...header,
        low: [box[0], box[1], box[2]],
        extent: [box[3], box[4], box[5]],
        surface: take.u16(3 * a),
        front: take.u16(3 * b),
        pulls: take.f32(7 * c),
      };
      break;
    }
    default:
      throw new ProtocolError(`a binary message has the unknown type ${view.getUint8(0)}`);
  }
  take.finish();
  return message;
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
