// The mock's simulation: an analytically wobbling ball that answers the commands of server/PROTOCOL.md.

import { editCommand, keepCommand, SCENES } from "./mock_commands.mjs";
import { helloOf, NO_BUDGET, recordingOf, SCENE, settingsOf, stateOf } from "./mock_messages.mjs";
import { ball, frontGrid } from "./mock_shapes.mjs";
import { encodeFrame, encodeTopology } from "./mock_wire.mjs";

export class MockSimulation {
  viewers = new Set();
  pulls = new Map(); // key -> { viewer, triangle, barycentric, target, force }
  commands = []; // every command received, for tests
  epoch = 1;
  sequence = 1;
  generation = 1;
  time = 0;
  step = 0;
  speed = 1;
  gravity = SCENE.gravity;
  tolerance = SCENE.tolerance;
  timeStep = 1 / 60;
  fine = false;
  warning = "";
  failed = false;
  colouringsSent = 0;
  order = SCENE.order;
  levels = SCENE.levels;
  wantedLevels = { min: 0, max: 99 };
  stiffness = 1;
  stiffnessParts = []; // as in "settings"
  damping = { mass: 0, stiffness: 0 };
  budget = NO_BUDGET;
  forces = []; // as in "settings"
  pins = [];
  sceneForces = []; // as in "state"
  recording = null; // { name, frames }
  recordings = [];
  /** @type {{ frames: number, start: number, end: number, colouring: string } | null} */
  recorded = null; // as in "hello": what plays is a recording
  /** @type {{ point: number[], normal: number[] } | null} */
  cut = null; // of the scene's view
  lacks = []; // capabilities of newer servers
  scene = SCENES[0];
  refusals = {}; // command -> what is said instead of doing it

  constructor(greet, { detail = 4, playing = true } = {}) {
    this.detail = detail;
    this.greet = greet;
    this.shape = ball(detail);
    this.front = frontGrid(false);
    this.playing = playing;
    this.shift = new Float64Array(this.shape.rest.length); // of each surface coordinate by pulls
  }

  hello = () => helloOf(this);
  state = () => stateOf(this);
  settings = () => settingsOf(this);
  recordingState = () => recordingOf(this);

  limitLevels() {
    const deepest = this.order === 2 ? 1 : 2;
    const max = Math.min(this.wantedLevels.max, deepest);
    this.levels = { min: Math.min(this.wantedLevels.min, max), max };
  }

  /** Of a colouring at each surface vertex; displacement is the true one, the others rise with height. */
  values(colouring, surface) {
    const { rest } = this.shape;
    const scale = { displacement: 1, strain: 0.2, stress: 2e5, error: 1e-4 }[colouring];
    return Float64Array.from({ length: rest.length / 3 }, (_, v) =>
      colouring === "displacement"
        ? Math.hypot(...[0, 1, 2].map((i) => surface[3 * v + i] - rest[3 * v + i]))
        : scale * rest[3 * v + 2],
    );
  }

  /** As a step that fails even when it is cut in pieces. */
  fail() {
    this.playing = false;
    this.failed = true;
    this.warning = "the simulation failed: 3 steps were rejected";
    this.tell(this.state());
  }

  advance() {
    if (this.playing) this.run((this.speed / 30) * (1 / this.timeStep));
  }

  run(steps) {
    this.step += Math.max(1, Math.round(steps));
    this.time = this.step * this.timeStep;
    this.relax();
    this.broadcast();
  }

  /** The object gives way to its pulls by and by; without them it goes back. */
  relax() {
    const { rest } = this.shape;
    const wanted = new Float64Array(rest.length);
    for (const pull of this.pulls.values()) {
      const anchor = this.at(rest, pull);
      const held = this.at(this.positions(), pull);
      pull.from = held;
      pull.force = 40 * Math.hypot(...pull.target.map((x, i) => x - held[i]));
      for (let v = 0; v < rest.length; v += 3) {
        const squared = (rest[v] - anchor[0]) ** 2 + (rest[v + 1] - anchor[1]) ** 2 + (rest[v + 2] - anchor[2]) ** 2;
        const weight = 0.8 * Math.exp(-squared / 0.12) * Math.min(1, 4 * rest[v + 2]);
        for (let i = 0; i < 3; ++i) wanted[v + i] += weight * (pull.target[i] - anchor[i]);
      }
    }
    for (const force of this.forces) {
      const anchor = this.at(rest, force);
      for (let v = 0; v < rest.length; v += 3) {
        const squared = (rest[v] - anchor[0]) ** 2 + (rest[v + 1] - anchor[1]) ** 2 + (rest[v + 2] - anchor[2]) ** 2;
        const weight = (2e-5 / this.stiffness) * Math.exp(-squared / 0.12);
        for (let i = 0; i < 3; ++i) wanted[v + i] += weight * force.value[i];
      }
    }
    const pins = this.pins.map((pin) => ({ ...pin, anchor: this.at(rest, pin) }));
    for (let v = 0; v < rest.length && pins.length; v += 3) {
      const within = ({ anchor, radius }) => Math.hypot(...anchor.map((x, i) => rest[v + i] - x)) <= radius;
      // The last word on a place counts.
      if (pins.findLast(within)?.pinned) for (let i = 0; i < 3; ++i) wanted[v + i] = this.shift[v + i];
    }
    for (let i = 0; i < rest.length; ++i) this.shift[i] += 0.35 * (wanted[i] - this.shift[i]);
    if (this.pulls.size > 0 !== this.fine) {
      this.fine = this.pulls.size > 0;
      this.front = frontGrid(this.fine);
      ++this.epoch;
    }
  }

  at(positions, { triangle, barycentric }) {
    const corners = this.shape.triangles.subarray(3 * triangle, 3 * triangle + 3);
    return [0, 1, 2].map((i) => corners.reduce((sum, v, c) => sum + barycentric[c] * positions[3 * v + i], 0));
  }

  sway(height) {
    return -0.009 * this.gravity[2] * height ** 2 * Math.sin(4 * this.time);
  }

  positions() {
    return this.shape.rest.map((x, i) => x + this.shift[i] + (i % 3 === 0 ? this.sway(this.shape.rest[i + 2]) : 0));
  }

  frontPositions() {
    return this.front.vertices.map((x, i) => x + (i % 3 === 0 ? this.sway(this.front.vertices[i + 2]) : 0));
  }

  surfaceLevels() {
    const { rest } = this.shape;
    return Uint8Array.from({ length: rest.length / 3 }, (_, v) => {
      if (!this.fine) return rest[3 * v + 2] < 0.3 ? 1 : 0;
      return rest[3 * v] > 0.1 ? 2 : rest[3 * v] > -0.2 ? 1 : 0;
    });
  }

  broadcast() {
    ++this.sequence;
    if (this.recording && this.playing) ++this.recording.frames;
    const frames = new Map(); // by colouring
    for (const viewer of this.viewers) {
      const { colouring } = viewer;
      if (!frames.has(colouring)) frames.set(colouring, encodeFrame(this, colouring));
      this.show(viewer, frames.get(colouring));
      if (!this.playing || this.sequence % 3 === 0) viewer.json(this.state());
    }
  }

  /** Two frames at most are on their way to who acknowledges; what comes in between is dropped. */
  show(viewer, frame) {
    const { socket, acknowledged, flying } = viewer;
    viewer.behind = acknowledged > 0 && flying.length >= 2;
    if (viewer.behind) return;
    if (viewer.epoch !== this.epoch) socket.send(encodeTopology(this));
    viewer.epoch = this.epoch;
    flying.push(this.sequence);
    socket.send(frame);
  }

  acknowledge(viewer, sequence) {
    viewer.acknowledged = sequence;
    viewer.flying = viewer.flying.filter((sent) => sent > sequence);
    if (viewer.behind) this.show(viewer, encodeFrame(this, viewer.colouring));
  }

  endPulls(viewer) {
    for (const [key, pull] of this.pulls) if (pull.viewer === viewer) this.pulls.delete(key);
  }

  tell(message) {
    for (const viewer of this.viewers) viewer.json(message);
  }

  /** Returns what is wrong (with a code), what the answer has in addition, or nothing. */
  command(viewer, command) {
    this.commands.push(command);
    const wrong = (pointer, message) => ({ code: "out_of_range", pointer, message });
    const refused = this.refusals[command.command];
    if (refused) return { code: "failed", pointer: "", message: refused };
    const pull = this.pulls.get(command.pull);
    switch (command.command) {
      case "play":
      case "pause":
        this.playing = command.command === "play";
        break;
      case "reset":
        this.time = this.step = 0;
        this.failed = false;
        this.warning = "";
        this.pulls.clear();
        this.shift.fill(0);
        break;
      case "step":
        if (this.playing) return { code: "failed", pointer: "", message: "pause first" };
        this.run(command.count ?? 1);
        return undefined;
      case "speed":
        if (!(command.value >= 0.01 && command.value <= 10)) return wrong("/value", "use 0.01..10");
        this.speed = command.value;
        break;
      case "gravity":
        this.gravity = command.value;
        break;
      case "tolerance":
        if (!(command.value >= 1e-6 && command.value <= 1)) return wrong("/value", `is ${command.value}; use 1e-06..1`);
        this.tolerance = command.value;
        break;
      case "pull_begin":
        if (command.triangle >= this.shape.triangles.length / 3) return wrong("/triangle", "there is no such triangle");
        this.pulls.set(command.pull, { viewer, ...command, from: this.at(this.positions(), command), force: 0 });
        break;
      case "pull_move":
        if (pull) pull.target = command.target;
        break;
      case "pull_end":
        this.pulls.delete(command.pull);
        break;
      default: {
        const done = editCommand(this, command) ?? keepCommand(this, viewer, command);
        if (done) return done;
        return { code: "unknown_command", pointer: "/command", message: `there is no command ${command.command}` };
      }
    }
    this.broadcast();
    return undefined;
  }

  load(scene) {
    this.scene = scene;
    this.shape = ball(scene.detail ?? this.detail);
    this.shift = new Float64Array(this.shape.rest.length);
    Object.assign(this, { ...SCENE, budget: NO_BUDGET, wantedLevels: { min: 0, max: 99 } });
    Object.assign(this, { forces: [], pins: [], stiffness: 1, stiffnessParts: [], damping: { mass: 0, stiffness: 0 } });
    this.pulls.clear();
    this.time = this.step = 0;
    ++this.generation;
    ++this.epoch;
    for (const viewer of this.viewers) this.greet(viewer, this);
  }
}
