// tetfront.v1's text messages: JSON both ways. Pure, no state, no imports; the contract is server/PROTOCOL.md.
//
//     const message = parseText(event.data);               // throws ProtocolError; null: a type this page does not know
//     socket.send(encodeCommand(7, { command: "play" }));

export const SUBPROTOCOL = "tetfront.v1";
export const PROTOCOL = 1;

export type Vec3 = readonly [number, number, number];
export type FieldColouring = "displacement" | "strain" | "stress" | "error"; // frames carry their values on request
export type Colouring = "level" | "stiffness" | FieldColouring;

/** A message that does not follow the protocol; the connection cannot be trusted any more. */
export class ProtocolError extends Error {
  override name = "ProtocolError";
}

// ---------------------------------------------------------------- server to client

export type Capability = "acknowledge" | "colouring" | "compress" | "edit" | "load" | "record" | "save";

/** What lies on the side of the normal is hidden. */
export interface CutPlane {
  point: readonly number[]; // [m] at rest
  normal: readonly number[]; // of any length
}

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
    cut?: CutPlane;
  };
  // The scene's own: what commands have set since is in "state" and "settings".
  gravity: Vec3; // [m/s²]
  tolerance: number;
  time_step: number; // [s]
  order: number;
  levels?: Levels; // older servers have none; of the tree's, whatever the order
  budget?: Budget; // older servers have none
  playing: boolean;
  speed: number; // simulated seconds per real second
  recording?: Recorded | null; // what plays is a recording
  limits: { message_bytes: number };
  capabilities?: readonly Capability[];
}

export interface Recorded {
  frames: number;
  start: number; // [s]
  end: number;
  colouring?: FieldColouring | "level"; // that its frames have values of; older servers do not say
}

export interface Phases {
  adapt: number; // [ms] of the last step
  setup: number;
  assemble: number;
  solve: number;
  other: number;
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
  phases?: Phases;
  energy?: { kinetic: number; elastic: number }; // [J]
  iterations: number;
  converged: boolean;
  viewers: number;
  warning: string; // "" or one line
  failed?: boolean; // the simulation was given up: reset starts again
  forces?: readonly SceneForce[]; // of the scene, that act now
}

export interface SceneForce {
  at: Vec3; // [m] middle of where it acts, now
  value: Vec3; // [N] in total
}

/** A point of the surface. */
export interface SurfacePlace {
  triangle: number;
  barycentric: Vec3; // each 0..1, sum 1
}

export interface Force extends SurfacePlace {
  force: number; // its number, shared by all clients
  value: Vec3; // [N]
}

export interface Pin extends SurfacePlace {
  pinned: boolean;
  radius: number; // [m] around the point at rest
}

/** Times the scene's stiffness, on top of the scale of everything. */
export interface StiffnessPart extends SurfacePlace {
  value: number; // 0.01..100
  radius: number; // [m] around the point at rest
}

/** That tets can have: within 0..depth. */
export interface Levels {
  min: number;
  max: number;
}

/** For a step; null: no limit. */
export interface Budget {
  tets: number | null;
  milliseconds: number | null;
}

/** What commands have set and all clients share. */
export interface Settings {
  type: "settings";
  order: number;
  levels?: Levels; // older servers have none
  stiffness_scale: number;
  stiffness_parts?: readonly StiffnessPart[]; // the last word on a place counts; older servers have none
  damping: { mass: number /* 1/s */; stiffness: number /* s */ };
  budget: Budget;
  forces: readonly Force[];
  pins: readonly Pin[]; // in the order in which they were made
}

export interface RecordingState {
  type: "recording";
  active: boolean;
  name: string;
  frames: number;
  seconds: number; // simulated
  bytes: number;
  problem: string; // "" or why it ended by itself
}

/** How the connection fares, for this client. */
export interface LinkReport {
  type: "link";
  sent: number;
  dropped: number; // frames that newer ones replaced before they were sent
  unacknowledged: number;
  round_trip: number | null; // [s]
}

export interface Log {
  type: "log";
  level: "info" | "warning";
  message: string;
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
  scenes?: readonly { name: string; title: string }[];
  recordings?: readonly { name: string; bytes: number }[];
  video?: boolean; // whether the server makes videos of them
}

export interface Refusal {
  type: "error";
  id: number | null;
  code: string;
  pointer: string;
  message: string;
}

export type TextMessage =
  Hello | SimulationState | Settings | RecordingState | LinkReport | Log | Progress | Answer | Refusal;

const REQUIRED: Record<TextMessage["type"], readonly string[]> = {
  hello: [
    ...["protocol", "version", "scene", "up", "depth", "young_range", "rest_box", "view", "gravity", "tolerance"],
    ...["time_step", "order", "playing", "speed", "limits"],
  ],
  state: [
    ...["playing", "speed", "time", "step", "steps_per_second", "tets_by_level", "free_vertices", "estimate"],
    ...["tolerance", "gravity", "milliseconds", "iterations", "converged", "viewers", "warning"],
  ],
  settings: ["order", "stiffness_scale", "damping", "budget", "forces", "pins"],
  recording: ["active", "name", "frames", "seconds", "bytes", "problem"],
  link: ["sent", "dropped", "unacknowledged", "round_trip"],
  log: ["level", "message"],
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

// ---------------------------------------------------------------- client to server

export type Command =
  | { command: "play" | "pause" | "reset" }
  | { command: "step"; count?: number } // 1..1000, while paused
  | { command: "speed"; value: number } // 0.01..10
  | ({ command: "pull_begin"; pull: number; target: Vec3 } & SurfacePlace)
  | { command: "pull_move"; pull: number; target: Vec3 }
  | { command: "pull_end"; pull: number }
  | { command: "gravity"; value: Vec3 } // [m/s²]
  | { command: "tolerance"; value: number } // 1e-6..1
  | { command: "budget"; tets?: number; milliseconds?: number }
  | { command: "colouring"; value: Colouring }
  | { command: "compression"; value: boolean } // of the frames to this page
  | ({ command: "force_add"; force: number; value: Vec3 } & SurfacePlace)
  | ({ command: "force_move"; force: number; value: Vec3 } & Partial<SurfacePlace>)
  | { command: "force_remove"; force: number }
  | ({ command: "pin" | "unpin"; radius: number } & SurfacePlace)
  | { command: "stiffness_scale"; value: number } // 0.01..100, everywhere
  | ({ command: "stiffness_scale" } & StiffnessPart)
  | { command: "damping"; mass: number; stiffness: number }
  | { command: "order"; value: number } // 1 or 2
  | ({ command: "levels" } & Levels) // deeper than the scene goes: as deep as it goes
  | { command: "scenes" | "recordings" }
  | { command: "load"; scene: string }
  | { command: "record_start"; colouring?: Colouring; fps?: number }
  | { command: "record_stop" }
  | { command: "seek"; time: number }; // [s] of a recording

/** One text message. JSON has no NaN or infinity, so such a number is refused here, where it was made. */
export function encodeCommand(id: number, command: Command): string {
  return JSON.stringify({ id, ...command }, (key, value: unknown) => {
    if (typeof value === "number" && !Number.isFinite(value))
      throw new RangeError(`${command.command}: ${key} is not a finite number`);
    return value;
  });
}

/** This frame and all before it have been shown. It has no answer. */
export const encodeAcknowledgement = (sequence: number): string => JSON.stringify({ command: "ack", frame: sequence });
