// Puts the parts together: worker <-> connection -> store -> viewer and page.

import { shareByAddress } from "./address";
import { Connection } from "./connection";
import type { Colouring, Command } from "./messages";
import { buildPage } from "./page";
import { byId } from "./panels/dom";
import { Toasts } from "./panels/toasts";
import type { BinaryMessage } from "./protocol";
import { isField } from "./scale";
import { worker } from "./socket";
import { can, initialState, Store } from "./store";
import { followTheme } from "./theme";
import { Viewer } from "./viewer/viewer";

const store = new Store({ ...initialState });
const toasts = new Toasts();
document.body.append(toasts.element);
followTheme(store);

/** What a command is called when the server refuses it. */
const NAMES: Partial<Record<Command["command"], string>> = {
  pull_begin: "Pull",
  pull_move: "Pull",
  pull_end: "Pull",
  force_add: "Force",
  force_move: "Force",
  force_remove: "Force",
  stiffness_scale: "Stiffness",
  load: "Opening the scene",
  scenes: "Scenes",
  record_start: "Recording",
  record_stop: "Recording",
};
const nameOf = ({ command }: Command): string => NAMES[command] ?? command.charAt(0).toUpperCase() + command.slice(1);

const canvas = byId<HTMLCanvasElement>("view");
let connection: Connection | undefined;
const send = (command: Command): void => connection?.send(command);

const viewer = tryViewer();
if (viewer) start(viewer);
else worker.terminate();

/** Null, and a message in the middle of the page, when the browser has no WebGL 2. */
function tryViewer(): Viewer | null {
  try {
    // For machines without a graphics processor: http://127.0.0.1:8080/?quality=low
    const frugal = new URLSearchParams(location.search).get("quality") === "low";
    return new Viewer(canvas, byId("labels"), store, send, frugal);
  } catch (error) {
    byId("fatal").hidden = false;
    byId("fatal-detail").textContent = error instanceof Error ? error.message : String(error);
    return null;
  }
}

function start(viewer: Viewer): void {
  worker.onerror = ({ message }: Partial<ErrorEvent>) => {
    if (message) toasts.show(`The connection's worker failed: ${message}`);
  };
  connection = new Connection(worker, store, {
    binary: (message: BinaryMessage) => viewer.receive(message),
    refused: (command, message) => {
      if (command?.command === "stiffness_scale") viewer.hands.partEdits.forget();
      if (command?.command === "pull_begin" || command?.command === "pull_move") viewer.hands.pull.drop();
      if (command?.command === "colouring" && command.value === store.get().colouring)
        store.set({ colouring: "level" });
      store.set({ refusals: store.get().refusals + 1 });
      toasts.show(command ? `${nameOf(command)}: ${message}` : message);
    },
    interrupted: () => viewer.interrupted(),
    told: (message) => toasts.show(message, "info"),
  });
  const link = connection;
  viewer.drawn = (sequence) => link.drawn(sequence);
  const look = () => (link.hidden = document.hidden);
  document.addEventListener("visibilitychange", look);
  look();
  addEventListener("online", () => {
    if (store.get().link.status === "waiting") link.connect();
  });
  canvas.addEventListener("webglcontextlost", () =>
    toasts.show("The picture was lost; it comes back as soon as the browser can draw again"),
  );
  const address = new URL("ws", document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  link.connect(address.href);
  buildPage({
    store,
    viewer,
    canvas,
    toasts,
    send,
    request: (command) => link.request(command),
    retry: () => link.connect(),
  });
  viewer.cameraMoved = shareByAddress({
    store,
    rig: viewer.rig,
    send,
    tell: (message) => toasts.show(message, "info"),
  });
  askForValues();

  // For the browser's console and the tests: what is shown now, read-only.
  Object.assign(window, {
    tetfront: {
      state: () => store.get(),
      positions: () => viewer.positions?.slice() ?? null,
      frame: () => viewer.frame,
      redraws: () => viewer.redraws,
      census: () => viewer.census,
      costs: () => viewer.costs.slice(),
      moments: () => viewer.history.length,
      times: () => viewer.history.times,
    },
  });
}

/** The server sends values only of the field that this page shows; to a new client, none. */
function askForValues(): void {
  let asked: Colouring = "level";
  const ask = () => {
    const { colouring } = store.get();
    const wanted = isField(colouring) ? colouring : "level";
    if (!can(store.get(), "colouring") || wanted === asked) return;
    asked = wanted;
    send({ command: "colouring", value: wanted });
  };
  store.watch(
    (s) => s.link.status,
    () => (asked = "level"),
  );
  store.watch((s) => s.colouring, ask);
  store.watch((s) => can(s, "colouring"), ask);
}
