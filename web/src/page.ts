// The panels around the picture, and what opens and closes them.

import { makeActions } from "./actions";
import { CameraPath } from "./camera_path";
import { bindings, leaveToShortcuts, listen } from "./keys";
import type { Answer, Command } from "./messages";
import { aim } from "./panels/aim";
import { banner, pill } from "./panels/banner";
import { byId, h, iconButton } from "./panels/dom";
import { group, toggle } from "./panels/fields";
import { helpSheet } from "./panels/help";
import { legend } from "./panels/legend";
import { recordingSheet, sceneSheet } from "./panels/library";
import { loads } from "./panels/loads";
import { parts as partList } from "./panels/parts";
import { physics } from "./panels/physics";
import { plots } from "./panels/plots";
import { status } from "./panels/status";
import type { Toasts } from "./panels/toasts";
import { toolbar } from "./panels/toolbar";
import { view } from "./panels/view";
import { download, exportQuery, fetchSnapshot, serverDraws, snapshotQuery } from "./snapshot";
import { can, isOpen } from "./store";
import type { Store } from "./store";
import type { Viewer } from "./viewer/viewer";

export interface PageParts {
  store: Store;
  viewer: Viewer;
  canvas: HTMLCanvasElement;
  toasts: Toasts;
  send: (command: Command) => void;
  request: (command: Command) => Promise<Answer | null>;
  retry: () => void;
}

export function buildPage(parts: PageParts): void {
  const { store, viewer, canvas, send, request } = parts;
  const actions = makeActions(store, send, viewer.rig, viewer.hands);
  const scenes = sceneSheet(store, request);
  const path = followCamera(store, viewer);
  const recordings = recordingSheet(
    store,
    request,
    (name) => exportQuery(store.get(), viewer.framing, name, path.keyframes(name)),
    (message) => parts.toasts.show(message),
  );
  const plotCard = plots(store);
  const panel = h("aside", {
    className: "card panel",
    id: "panel",
    attributes: { "aria-label": "Numbers and settings" },
  });
  const legendCard = legend(store, () => viewer.gridSpacing);
  const bar = toolbar(store, actions, send, () => viewer.history.range);
  const docks = docking(viewer, panel, plotCard, keepApart(legendCard, bar));
  const keep = {
    help: () => help.toggle(),
    plots: docks.plots.toggle,
    scenes: () => can(store.get(), "load") && scenes.open(),
    snapshot: (source: "server" | "canvas") => void takePicture(parts, source),
  };
  const help = helpSheet(() => table);
  const table = bindings(actions, keep);
  listen(table, () => store.get().pullsByKeys);

  panel.append(
    status(store),
    view(store),
    ...physics(store, send),
    partList(store, viewer.hands.partEdits),
    loads(store, send),
    keeping(store, keep.snapshot, recordings.open),
  );
  byId("chrome").append(
    aim(store),
    heading(store, scenes.open),
    banner(store, { retry: parts.retry, reload: () => location.reload(), reset: actions.reset, done: actions.putDown }),
    h(
      "nav",
      { className: "card corner", attributes: { "aria-label": "Page" } },
      iconButton("home", "Whole object in view", "F", actions.home),
      iconButton("camera", "Picture", "S", () => keep.snapshot("server")),
      iconButton("theme", "Light or dark", "T", actions.toggleTheme),
      iconButton("help", "Keys and gestures", "?", help.toggle),
      docks.plots.button,
      docks.panel.button,
    ),
    plotCard,
    panel,
    legendCard,
    bar,
  );
  document.body.append(help.element, scenes.element, recordings.element);
  store.watch(isOpen, (open) => canvas.classList.toggle("stale", !open));
  viewer.hands.missed = () =>
    parts.toasts.show(
      store.get().pointing ? "The object is not under the pointer" : "The object is not in the middle of the picture",
      "info",
    );
  // A tool is used on the picture, which a narrow window hides behind the panel.
  store.watch(
    (s) => s.tool,
    (tool) => tool && !isWide() && docks.panel.show(false),
  );
  leaveToShortcuts(byId("chrome"));
}

/** Where the camera is while this page sees a recording grow. */
function followCamera(store: Store, viewer: Viewer): CameraPath {
  const path = new CameraPath();
  setInterval(() => {
    const { recording } = store.get();
    if (!recording?.active || !viewer.frame) return;
    const { eye, target } = viewer.framing;
    path.sample(recording.name, viewer.frame.time, eye, target);
  }, 200);
  return path;
}

const isWide = () => innerWidth >= 860; // as in narrow.css
const BARS = { top: 58, bottom: 66 }; // [px] heights of the rows of cards with their margins
const DOCK = 284; // [px] width of a dock with its margin

/** The legend stands above the toolbar where both do not fit into a row. Returns what looks again, after the toolbar was moved. */
function keepApart(legendCard: HTMLElement, bar: HTMLElement): () => void {
  const look = () => {
    const { right } = legendCard.getBoundingClientRect();
    legendCard.classList.toggle("raised", bar.getBoundingClientRect().left < right + 8);
  };
  const observer = new ResizeObserver(look);
  for (const element of [legendCard, bar]) observer.observe(element);
  return look;
}

/** In a narrow window a dock is a sheet over the picture; elsewhere the picture makes room for one, or for both. */
function docking(viewer: Viewer, panel: HTMLElement, plotCard: HTMLElement, moved: () => void) {
  const hasRoomForBoth = () => innerWidth >= 1100;
  const cover = () => {
    const left = isWide() && !plotCard.hidden ? DOCK : 0;
    const right = isWide() && !panel.hidden ? DOCK : 0;
    viewer.cover({ ...BARS, left, right });
    // What is in the middle is in the middle of what is free.
    const { style } = document.documentElement;
    style.setProperty("--middle", `calc(50% + ${(left - right) / 2}px)`);
    style.setProperty("--centre", `calc(50% + ${(BARS.top - BARS.bottom) / 2}px)`);
    style.setProperty("--docks", `${left + right}px`);
    moved();
  };
  const dock = (element: HTMLElement, other: HTMLElement, icon: "panel" | "plots", label: string, key: string) => {
    const toggle = () => show(element.hidden);
    const button = iconButton(icon, label, key, toggle);
    button.setAttribute("aria-controls", element.id);
    const show = (visible: boolean) => {
      element.hidden = !visible;
      button.setAttribute("aria-expanded", String(visible));
      if (visible && !hasRoomForBoth() && !other.hidden)
        document.querySelector<HTMLButtonElement>(`[aria-controls=${other.id}]`)?.click();
      cover();
    };
    return { button, toggle, show };
  };
  const docks = {
    panel: dock(panel, plotCard, "panel", "Numbers and settings", "button"),
    plots: dock(plotCard, panel, "plots", "Plots", "G"),
  };
  addEventListener("resize", () => {
    if (!hasRoomForBoth() && !panel.hidden && !plotCard.hidden) docks.plots.show(false);
    cover();
  });
  docks.panel.show(isWide());
  docks.plots.show(hasRoomForBoth() && innerHeight >= 680);
  return docks;
}

/** The scene's title, which opens the scenes where there are some, and the state of the connection. */
function heading(store: Store, openScenes: () => void): HTMLElement {
  const title = h("h1");
  const button = iconButton("scenes", "Open another scene", "O", openScenes);
  store.watch(
    (s) => s.hello,
    (hello) => {
      const name = hello ? hello.scene.title || hello.scene.name : "tetfront";
      title.textContent = title.title = name;
      document.title = hello ? `${name} · tetfront` : "tetfront";
    },
  );
  store.watch(
    (s) => can(s, "load"),
    (able) => (button.hidden = !able),
  );
  return h("header", { className: "card heading" }, button, title, pill(store));
}

function keeping(store: Store, snapshot: (source: "server" | "canvas") => void, recordings: () => void): HTMLElement {
  const button = (text: string, title: string, onclick: () => void) =>
    h("button", { type: "button", title, onclick }, text);
  const list = button("Recordings …", "Download what was recorded", recordings);
  store.watch(
    (s) => can(s, "record"),
    (able) => (list.hidden = !able),
  );
  return group(
    "Keep",
    true,
    h(
      "div",
      { className: "row wrap" },
      button("Picture", "Drawn by the server, with its legend (S)", () => snapshot("server")),
      button("Canvas", "As this page draws it, without a background (Shift S)", () => snapshot("canvas")),
      list,
    ),
    toggle(
      store,
      "Picture without background",
      (s) => s.transparent,
      (transparent) => store.set({ transparent }),
    ),
  );
}

async function takePicture({ store, viewer, toasts }: PageParts, source: "server" | "canvas"): Promise<void> {
  const state = store.get();
  if (!state.hello) return;
  const byServer = source === "server" && serverDraws(state);
  const time = byServer ? state.simulation?.time : viewer.frame?.time;
  const name = `${state.hello.scene.name}-${(time ?? 0).toFixed(2)}s.png`;
  try {
    const blob = byServer ? await fetchSnapshot(snapshotQuery(state, viewer.framing)) : await viewer.toBlob();
    if (!blob) throw new Error("the canvas gave no picture");
    download(blob, name);
    if (source === "server" && !byServer)
      toasts.show("Drawn by this page: the server draws only the surface, and only the present", "info");
  } catch (error) {
    toasts.show(`Picture: ${error instanceof Error ? error.message : String(error)}`);
  }
}
