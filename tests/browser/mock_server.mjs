// A false tetfront: speaks server/PROTOCOL.md with an analytically wobbling ball, for browser tests that need no C++.
//
//     node tests/browser/mock_server.mjs 8080                  # then open http://127.0.0.1:8080/
//     const server = await startMockServer();  server.url;  await server.close();
//
// The ball stands on the ground, sways while it plays and follows pulls. A pull refines the front near it, so that
// topologies change while frames flow.

import { EventEmitter, once } from "node:events";
import { createReadStream, existsSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { createRequire } from "node:module";
import { dirname, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

import { MockSimulation } from "./mock_simulation.mjs";
import { encodeFrame, encodeModel, encodeTopology } from "./mock_wire.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const { WebSocketServer } = createRequire(join(here, "../../web/package.json"))("ws");
const DIST = join(here, "../../web/dist");
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };
// One orange pixel.
const THUMBNAIL = Buffer.from(
  "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGO4Wc4GAAODAVdvW79nAAAAAElFTkSuQmCC",
  "base64",
);
const POLICY =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; font-src 'self'; connect-src 'self'; " +
  "worker-src 'self'; manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/** options: port (0: any), detail (of the ball, 1..6), playing, building: milliseconds of false progress, token: that is asked for, most: clients,
 * archive: bytes of a recording's pictures, of which no more than `hold` are sent until `held` emits "go". */
export async function startMockServer(options = {}) {
  const simulation = new MockSimulation(greet, options);
  const archive = { size: options.archive ?? 0, sent: 0, broken: 0, hold: Infinity, held: new EventEmitter() };
  const http = createServer((request, response) => serve(request, response, options.token, archive));
  const sockets = new WebSocketServer({ server: http, path: "/ws", handleProtocols: () => "tetfront.v1" });
  sockets.on("connection", (socket, request) => {
    if (simulation.viewers.size >= (options.most ?? Infinity)) socket.close(1013, "there are too many clients");
    else if (authorized(request, options.token)) void welcome(socket, simulation, options.building ?? 0);
    else socket.close(4001);
  });
  const timer = setInterval(() => simulation.advance(), 1000 / 30);
  await new Promise((resolve) => http.listen(options.port ?? 0, "127.0.0.1", resolve));
  const { port } = http.address();
  return {
    url: `http://127.0.0.1:${port}/`,
    port,
    simulation,
    archive,
    /** Ends every connection at once, as a killed process does. */
    async close() {
      clearInterval(timer);
      for (const socket of sockets.clients) socket.terminate();
      http.closeAllConnections();
      await new Promise((resolve) => http.close(resolve));
    },
  };
}

const authorized = ({ headers }, token) =>
  !token || headers.authorization === `Bearer ${token}` || headers.cookie === `tetfront_token=${token}`;

function serve(request, response, token, archive) {
  const path = normalize(new URL(request.url, "http://x").pathname);
  if (path === "/session") {
    const good = authorized(request, token);
    const cookie = { "set-cookie": `tetfront_token=${token}; Path=/; HttpOnly; SameSite=Strict` };
    response.writeHead(good ? 204 : 401, good ? cookie : {}).end();
  } else if (path.endsWith("/video.mp4")) {
    response.writeHead(422).end("there is no ffmpeg here; install it\n");
  } else if (path.endsWith("/frames.zip") && archive.size > 0) {
    void sendArchive(response, archive);
  } else if (path.startsWith("/recordings/")) {
    response.writeHead(200, { "content-type": "application/octet-stream" }).end(`recording ${path.slice(12)}`);
  } else if (path === "/thumbnails/mock.png") {
    response.writeHead(200, { "content-type": "image/png" }).end(THUMBNAIL);
  } else if (path.startsWith("/thumbnails/")) {
    response.writeHead(204).end();
  } else {
    serveFile(path, response);
  }
}

/** Byte i of it is i / 65536, so that a piece that is lost or doubled is seen. */
async function sendArchive(response, archive) {
  const closed = new Promise((resolve) => response.on("close", resolve));
  void closed.then(() => !response.writableFinished && ++archive.broken);
  response.writeHead(200, {
    "content-type": "application/zip",
    "content-disposition": "attachment; filename=mock.zip",
  });
  for (let sent = 0; sent < archive.size && !response.destroyed; archive.sent = sent) {
    if (sent >= archive.hold) await Promise.race([once(archive.held, "go"), closed]);
    const part = Buffer.alloc(Math.min(65536, archive.size - sent), sent / 65536);
    sent += part.length;
    if (!response.write(part)) await Promise.race([once(response, "drain"), closed]);
  }
  response.end();
}

function serveFile(path, response) {
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
  const viewer = { socket, json, epoch: 0, colouring: "level", acknowledged: 0, flying: [] };
  greet(viewer, simulation);
  simulation.viewers.add(viewer);
  simulation.tell(simulation.state());
  socket.on("close", () => {
    simulation.viewers.delete(viewer);
    simulation.endPulls(viewer);
    simulation.tell(simulation.state());
  });
  socket.on("message", (data) => {
    const command = JSON.parse(String(data));
    if (!simulation.viewers.has(viewer)) return; // a story has cut the line
    if (command.command === "ack") {
      simulation.acknowledge(viewer, command.frame);
      return;
    }
    const result = simulation.command(viewer, command) ?? {};
    json(result.code ? { type: "error", id: command.id, ...result } : { type: "ok", id: command.id, ...result });
  });
}

/** What a client gets first, and again when another scene has been loaded. */
function greet(viewer, simulation) {
  viewer.json(simulation.hello());
  viewer.socket.send(encodeModel(simulation.shape, simulation.generation));
  viewer.socket.send(encodeTopology(simulation));
  viewer.socket.send(encodeFrame(simulation, viewer.colouring));
  viewer.json(simulation.settings());
  viewer.json(simulation.state());
  viewer.epoch = simulation.epoch;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { url } = await startMockServer({ port: Number(process.argv[2] ?? 8080), building: 1000 });
  console.log(url);
}
