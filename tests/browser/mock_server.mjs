// A false tetfront: speaks server/PROTOCOL.md with an analytically wobbling ball, for browser tests that need no C++.
//
//     node tests/browser/mock_server.mjs 8080                  # then open http://127.0.0.1:8080/
//     const server = await startMockServer();  server.url;  await server.close();
//
// The ball stands on the ground, sways while it plays and follows pulls. A pull refines the front near it, so that
// topologies change while frames flow.

import { createReadStream, existsSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

import { ball, frontGrid } from "./mock_shapes.mjs";
import { encodeFrame, encodeModel, encodeTopology } from "./mock_wire.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const { WebSocketServer } = createRequire(join(here, "../../web/package.json"))("ws");
const DIST = join(here, "../../web/dist");
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };
const POLICY =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; font-src 'self'; connect-src 'self'; " +
  "worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/** options: port (0: any), detail (of the ball, 1..6), playing, building: milliseconds of false progress. */
export async function startMockServer(options = {}) {
  const simulation = new MockSimulation(options);
  const http = createServer(serveFile);
  const sockets = new WebSocketServer({ server: http, path: "/ws", handleProtocols: () => "tetfront.v1" });
  sockets.on("connection", (socket) => welcome(socket, simulation, options.building ?? 0));
  const timer = setInterval(() => simulation.advance(), 1000 / 30);
  await new Promise((resolve) => http.listen(options.port ?? 0, "127.0.0.1", resolve));
  const { port } = http.address();
  return {
    url: `http://127.0.0.1:${port}/`,
    port,
    simulation,
    /** Ends every connection at once, as a killed process does. */
    async close() {
      clearInterval(timer);
      for (const socket of sockets.clients) socket.terminate();
      http.closeAllConnections();
      await new Promise((resolve) => http.close(resolve));
    },
  };
}

function serveFile(request, response) {
  const path = normalize(new URL(request.url, "http://x").pathname);
  const file = join(DIST, path === "/" ? "index.html" : path);
  if (!file.startsWith(DIST) || !existsSync(file) || !statSync(file).isFile()) {
    response.writeHead(404).end();
    return;
  }
  response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "text/plain", "content-security-policy": POLICY });
  createReadStream(file).pipe(response);
}

async function welcome(socket, simulation, building) {
  const json = (message) => socket.send(JSON.stringify(message));
  for (let i = 0; i < 10 && building; ++i) {
    json({ type: "progress", what: "elasticity matrices", fraction: i / 10 });
    await new Promise((resolve) => setTimeout(resolve, building / 10));
  }
  json(simulation.hello());
  socket.send(encodeModel(simulation.shape));
  socket.send(encodeTopology(simulation));
  socket.send(encodeFrame(simulation));
  json(simulation.state());
  const viewer = { socket, json, epoch: simulation.epoch };
  simulation.viewers.add(viewer);
  socket.on("close", () => {
    simulation.viewers.delete(viewer);
    simulation.endPulls(viewer);
  });
  socket.on("message", (data) => {
    const command = JSON.parse(String(data));
    const problem = simulation.command(viewer, command);
    json(problem ? { type: "error", id: command.id, ...problem } : { type: "ok", id: command.id });
  });
}

class MockSimulation {
  viewers = new Set();
  pulls = new Map(); // key -> { viewer, triangle, barycentric, target, force }
  commands = []; // every command received, for tests
  epoch = 1;
  sequence = 0;
  generation = 1;
  time = 0;
  step = 0;
  speed = 1;
  gravity = [0, 0, -9.81];
  tolerance = 0.05;
  timeStep = 1 / 60;
  fine = false;
  warning = "";

  constructor({ detail = 4, playing = true } = {}) {
    this.shape = ball(detail);
    this.front = frontGrid(false);
    this.playing = playing;
    this.shift = new Float64Array(this.shape.rest.length); // of each surface coordinate by pulls
  }

  hello() {
    return {
      type: "hello",
      protocol: 1,
      version: "0.0.0-mock",
      scene: { name: "mock", title: "Wobbling ball (mock)" },
      up: 2,
      depth: 2,
      young_range: [1e5, 1e7],
      rest_box: [-0.5, -0.5, 0, 0.5, 0.5, 1],
      view: {
        ...{ eye: [1.6, -2.9, 1.5], target: [0, 0, 0.48], field_of_view: 32 },
        ...{ colouring: "level", wireframe: false },
      },
      gravity: [0, 0, -9.81],
      tolerance: 0.05,
      time_step: this.timeStep,
      order: 1,
      playing: this.playing,
      speed: this.speed,
      limits: { message_bytes: 65536 },
    };
  }

  state() {
    return {
      type: "state",
      playing: this.playing,
      speed: this.speed,
      time: this.time,
      step: this.step,
      steps_per_second: this.playing ? this.speed / this.timeStep : 0,
      tets_by_level: this.fine ? [620, 1480, 2210] : [720, 880, 0],
      free_vertices: this.fine ? 1432 : 412,
      estimate: this.fine ? 0.021 : 0.034,
      tolerance: this.tolerance,
      gravity: this.gravity,
      milliseconds: this.fine ? 7.31 : 2.04,
      iterations: 14,
      converged: true,
      viewers: this.viewers.size,
      warning: this.warning,
    };
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
    const frame = encodeFrame(this);
    for (const viewer of this.viewers) {
      if (viewer.epoch !== this.epoch) viewer.socket.send(encodeTopology(this));
      viewer.epoch = this.epoch;
      viewer.socket.send(frame);
      if (!this.playing || this.sequence % 3 === 0) viewer.json(this.state());
    }
  }

  endPulls(viewer) {
    for (const [key, pull] of this.pulls) if (pull.viewer === viewer) this.pulls.delete(key);
  }

  /** Returns what is wrong, or nothing. */
  command(viewer, command) {
    this.commands.push(command);
    const wrong = (pointer, message) => ({ code: "out_of_range", pointer, message });
    const pull = this.pulls.get(command.pull);
    switch (command.command) {
      case "play":
      case "pause":
        this.playing = command.command === "play";
        break;
      case "reset":
        this.time = this.step = 0;
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
      default:
        return { code: "unknown_command", pointer: "/command", message: `there is no command ${command.command}` };
    }
    this.broadcast();
    return undefined;
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { url } = await startMockServer({ port: Number(process.argv[2] ?? 8080), building: 1000 });
  console.log(url);
}
