// Puts the parts together: worker <-> connection -> store -> viewer and panels.

import "./styles.css";

import { makeActions } from "./actions";
import { Connection } from "./connection";
import { bindings, listen } from "./keys";
import { banner, pill } from "./panels/banner";
import { byId, h, iconButton } from "./panels/dom";
import { helpSheet } from "./panels/help";
import { legend } from "./panels/legend";
import { settings } from "./panels/settings";
import { status } from "./panels/status";
import { Toasts } from "./panels/toasts";
import { toolbar } from "./panels/toolbar";
import type { BinaryMessage, Command } from "./protocol";
import { initialState, Store } from "./store";
import { followTheme } from "./theme";
import { Viewer } from "./viewer/viewer";

const store = new Store({ ...initialState });
const toasts = new Toasts();
document.body.append(toasts.element);
followTheme(store);

const NAMES: Record<Command["command"], string> = {
  play: "Play",
  pause: "Pause",
  reset: "Reset",
  step: "Step",
  speed: "Speed",
  pull_begin: "Pull",
  pull_move: "Pull",
  pull_end: "Pull",
  gravity: "Gravity",
  tolerance: "Tolerance",
};

const canvas = byId<HTMLCanvasElement>("view");
let connection: Connection | undefined;
const send = (command: Command): void => connection?.send(command);

const viewer = tryViewer();
if (viewer) start(viewer);

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
  const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module", name: "tetfront socket" });
  worker.onerror = (event) => toasts.show(`The connection's worker failed: ${event.message}`);
  connection = new Connection(worker, store, {
    binary: (message: BinaryMessage) => viewer.receive(message),
    refused: (command, message) => toasts.show(command ? `${NAMES[command.command]}: ${message}` : message),
    interrupted: () => viewer.interrupted(),
  });

  const actions = makeActions(store, send, viewer.rig);
  const help = helpSheet(() => table);
  const table = bindings(actions, help.toggle);
  listen(table);

  const panel = h(
    "aside",
    { className: "card panel", id: "panel", attributes: { "aria-label": "Numbers and settings" } },
    status(store),
    settings(store, send),
  );
  const panelButton = iconButton("panel", "Numbers and settings", "button", () => showPanel(panel.hidden));
  panelButton.setAttribute("aria-controls", "panel");
  const showPanel = (visible: boolean) => {
    panel.hidden = !visible;
    panelButton.setAttribute("aria-expanded", String(visible));
    cover();
  };
  // In a narrow window the panel is a sheet over the picture; elsewhere the picture makes room for it.
  const isWide = () => innerWidth >= 720;
  const cover = () => viewer.cover({ top: 58, bottom: 66, right: isWide() && !panel.hidden ? 284 : 0 });
  addEventListener("resize", cover);
  showPanel(isWide());

  const title = h("h1");
  store.watch(
    (s) => s.hello,
    (hello) => {
      title.textContent = title.title = hello ? hello.scene.title || hello.scene.name : "tetfront";
      document.title = hello ? `${hello.scene.title || hello.scene.name} · tetfront` : "tetfront";
    },
  );
  store.watch(
    (s) => s.link.status === "open",
    (open) => canvas.classList.toggle("stale", !open),
  );

  byId("chrome").append(
    h("header", { className: "card heading" }, title, pill(store)),
    banner(store, { retry: () => connection?.connect(), reload: () => location.reload() }),
    h(
      "nav",
      { className: "card corner", attributes: { "aria-label": "Page" } },
      iconButton("home", "Whole object in view", "F", actions.home),
      iconButton("theme", "Light or dark", "T", actions.toggleTheme),
      iconButton("help", "Keys and gestures", "?", help.toggle),
      panelButton,
    ),
    panel,
    legend(store, () => viewer.gridSpacing),
    toolbar(store, actions),
  );
  document.body.append(help.element);
  // A button that was clicked would take the next Space for itself.
  byId("chrome").addEventListener("click", (event) => {
    if (event.detail > 0) (event.target as Element).closest("button")?.blur();
  });

  const address = new URL("ws", document.baseURI);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  connection.connect(address.href);

  // For the browser's console and the tests: what is shown now, read-only.
  Object.assign(window, {
    tetfront: {
      state: () => store.get(),
      positions: () => viewer.positions?.slice() ?? null,
      frame: () => viewer.frame,
      redraws: () => viewer.redraws,
    },
  });
}
