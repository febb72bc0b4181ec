// What is on the server: scenes that can be opened, recordings that can be downloaded. One sheet for each.

import { bytes } from "../format";
import type { Answer, Command } from "../messages";
import { isOpen } from "../store";
import type { Store } from "../store";
import { saveWhileMade } from "../save";
import { h, icon, throttle } from "./dom";

type Request = (command: Command) => Promise<Answer | null>;

export interface Sheet {
  element: HTMLDialogElement;
  open: () => void;
}

export function sceneSheet(store: Store, request: Request): Sheet {
  const body = h("ul", { className: "cards" });
  const { element, open } = sheet("Open a scene", "scenes", body, async () => {
    body.replaceChildren(h("li", { className: "note" }, "Asking the server …"));
    const answer = await request({ command: "scenes" });
    const now = store.get().hello?.scene.name;
    const pictures: [HTMLImageElement, string][] = [];
    const cards = (answer?.scenes ?? []).map(({ name, title }) => {
      const picture = h("img", { alt: "", hidden: true });
      pictures.push([picture, `thumbnails/${encodeURIComponent(name)}.png`]);
      const button = h(
        "button",
        {
          type: "button",
          onclick: () => {
            element.close();
            void request({ command: "load", scene: name });
          },
        },
        h("span", { className: "frame" }, picture),
        h("b", {}, title || name),
        h("small", {}, name === now ? `${name} · open now` : name),
      );
      if (name === now) button.setAttribute("aria-current", "true");
      return h("li", {}, button);
    });
    body.replaceChildren(...orNote(store, answer, cards, "The server offers no scenes."));
    void showOneByOne(pictures);
  });
  return { element, open };
}

/** The rows of a list, or why there are none. */
function orNote(store: Store, answer: Answer | null, rows: readonly Node[], none: string): readonly Node[] {
  if (rows.length) return rows;
  const unknown = isOpen(store.get()) ? "The server did not say." : "There is no connection to the server.";
  return [h("li", { className: "note" }, answer ? none : unknown)];
}

/** The server draws a picture when it is first asked for; one request at a time leaves the others to the page. */
async function showOneByOne(pictures: readonly [HTMLImageElement, string][]): Promise<void> {
  for (const [image, source] of pictures) {
    if (!image.isConnected) return;
    image.src = source;
    // A scene that cannot be drawn, as its model has not been fetched, keeps an empty frame.
    await image.decode().then(
      () => (image.hidden = false),
      () => undefined,
    );
  }
}

/** query: what the pictures of the recording of this name show. failed: tells of trouble while the sheet is closed. */
export function recordingSheet(
  store: Store,
  request: Request,
  query: (name: string) => string,
  failed: (message: string) => void,
): Sheet {
  const body = h("ul", { className: "files" });
  const problem = h("p", { className: "note problem", attributes: { role: "alert" } }); // toasts lie behind the sheet
  const exports: Exports = {
    query,
    failed: (message) => (element.open ? (problem.textContent = message) : failed(message)),
    running: new Map(),
  };
  const note = h(
    "p",
    { className: "note" },
    "Pictures, about ten a second, have the colours of the recording. Those of this scene have your camera, cut and wireframe.",
  );
  const { element, open } = sheet("Recordings", "recordings", h("div", {}, body, problem, note), async () => {
    body.replaceChildren(h("li", { className: "note" }, "Asking the server …"));
    const answer = await request({ command: "recordings" });
    const rows = (answer?.recordings ?? []).map(({ name, bytes: size }) => {
      const path = `recordings/${encodeURIComponent(name)}`;
      return h(
        "li",
        {},
        h("b", {}, name.replace(/\.tfr$/, "")),
        h("small", {}, bytes(size)),
        h("a", { href: path, download: name, title: "For tetfront render and tetfront serve" }, "Recording"),
        exportButton("Pictures", name, `${path}/frames.zip`, exports),
        answer?.video ? exportButton("Video", name, `${path}/video.mp4`, exports) : null,
      );
    });
    problem.textContent = "";
    body.replaceChildren(...orNote(store, answer, rows, "None yet: V starts one and ends it."));
  });
  return { element, open };
}

interface Exports {
  query: (name: string) => string;
  failed: (message: string) => void;
  /** Buttons of downloads that go on, by address: they outlive the sheet's closing, so that they can still be cancelled. */
  running: Map<string, HTMLButtonElement>;
}

/** Downloads what the server makes meanwhile; a second click ends it. */
function exportButton(label: string, name: string, url: string, { query, failed, running }: Exports): HTMLElement {
  const known = running.get(url);
  if (known) return known;
  let cancel: AbortController | null = null;
  const start = async () => {
    cancel = new AbortController();
    running.set(url, button);
    // Pieces come by the hundred a second; the last words may come after the end.
    const arrived = throttle(200, (size: number) => cancel && (button.textContent = `Cancel · ${bytes(size)}`));
    arrived(0);
    try {
      const file = name.replace(/\.tfr$/, url.slice(url.lastIndexOf(".")));
      await saveWhileMade(`${url}?${query(name)}`, file, arrived, cancel.signal);
    } catch (error) {
      failed(`${label}: ${error instanceof Error ? error.message : String(error)}`);
    }
    running.delete(url);
    cancel = null;
    button.textContent = label;
  };
  const button = h(
    "button",
    { type: "button", onclick: () => (cancel ? cancel.abort() : void start()), title: `${label} of ${name}` },
    label,
  );
  return button;
}

/** A dialog with a heading; `fill` is called each time it opens. */
function sheet(title: string, id: string, body: HTMLElement, fill: () => Promise<void>): Sheet {
  const close = h(
    "button",
    { type: "button", className: "icon small", onclick: () => element.close(), attributes: { "aria-label": "Close" } },
    icon("close"),
  );
  const element = h(
    "dialog",
    { className: "sheet", attributes: { "aria-labelledby": `${id}-title` } },
    h("header", {}, h("h2", { id: `${id}-title` }, title), close),
    body,
  );
  element.addEventListener("click", (event) => {
    if (event.target === element) element.close(); // the backdrop
  });
  return {
    element,
    open: () => {
      if (element.open) return;
      element.showModal();
      void fill();
    },
  };
}
