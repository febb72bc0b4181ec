// What is on the server: scenes that can be opened, recordings that can be downloaded. One sheet for each.

import { bytes } from "../format";
import type { Answer, Command } from "../messages";
import type { Store } from "../store";
import { h, icon } from "./dom";

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
    const cards = (answer?.scenes ?? []).map(({ name, title }) => {
      const button = h(
        "button",
        {
          type: "button",
          onclick: () => {
            element.close();
            void request({ command: "load", scene: name });
          },
        },
        h("b", {}, title || name),
        h("small", {}, name === now ? `${name} · open now` : name),
      );
      if (name === now) button.setAttribute("aria-current", "true");
      return h("li", {}, button);
    });
    body.replaceChildren(...(cards.length ? cards : [h("li", { className: "note" }, "The server offers no scenes.")]));
  });
  return { element, open };
}

export function recordingSheet(request: Request): Sheet {
  const body = h("ul", { className: "files" });
  return sheet("Recordings", "recordings", body, async () => {
    body.replaceChildren(h("li", { className: "note" }, "Asking the server …"));
    const answer = await request({ command: "recordings" });
    const rows = (answer?.recordings ?? []).map(({ name, bytes: size }) =>
      h(
        "li",
        {},
        h("a", { href: `recordings/${encodeURIComponent(name)}`, download: name }, name),
        h("small", {}, bytes(size)),
      ),
    );
    body.replaceChildren(
      ...(rows.length ? rows : [h("li", { className: "note" }, "None yet: V starts one and ends it.")]),
      h(
        "li",
        { className: "note" },
        h("code", {}, "tetfront render NAME --video"),
        " makes pictures and a video of one.",
      ),
    );
  });
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
