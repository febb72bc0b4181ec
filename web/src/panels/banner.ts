// What is going on when the picture is not live: connecting, reconnecting with a countdown, a model being built,
// trouble in the simulation. And the small pill beside the title that says the same in one word.

import type { LinkState } from "../link";
import { wantsReset } from "../store";
import type { State, Store } from "../store";
import { h } from "./dom";
import { modes } from "./modes";

export interface BannerActions {
  retry: () => void;
  reload: () => void;
  reset: () => void;
  done: () => void; // with what the hand does
}

export function banner(store: Store, actions: BannerActions): HTMLElement {
  const element = h("div", { className: "banners", attributes: { role: "status", "aria-live": "polite" } });
  const link = h("div");
  const progress = h("div");
  const trouble = h("div");
  element.append(link, progress, trouble, modes(store, actions.done));
  let timer: ReturnType<typeof setInterval> | undefined;

  store.watch(
    (s) => s.link,
    (state) => {
      clearInterval(timer);
      link.replaceChildren(...linkBanner(state, actions));
      const seconds = link.querySelector(".countdown");
      if (state.status === "waiting" && seconds) {
        const count = () => (seconds.textContent = String(Math.max(0, Math.ceil((state.until - Date.now()) / 1000))));
        count();
        timer = setInterval(count, 200);
      }
    },
  );
  store.watch(
    (s) => s.progress,
    (now) => {
      if (!now) progress.replaceChildren();
      else {
        const bar = h("progress", { max: 1, attributes: { "aria-label": now.what } });
        // Of some work it is not known how far it is: without a value the bar moves by itself.
        if (now.fraction > 0) bar.value = now.fraction;
        const percent = now.fraction > 0 ? ` (${Math.round(100 * now.fraction)} %)` : " …";
        const left = now.remaining && now.remaining >= 1 ? `, about ${Math.ceil(now.remaining)} s left` : "";
        const text = `Building the model: ${now.what}${percent}${left}`;
        progress.replaceChildren(h("div", { className: "card banner" }, h("span", {}, text), bar));
      }
    },
  );
  const showTrouble = () => {
    const text = troubleOf(store.get());
    trouble.replaceChildren(...(text ? [troubleBanner(text, wantsReset(store.get()) ? actions.reset : null)] : []));
  };
  store.watch(troubleOf, showTrouble);
  store.watch(wantsReset, showTrouble);
  return element;
}

function troubleBanner(text: string, reset: (() => void) | null): HTMLElement {
  const button = reset ? h("button", { type: "button", onclick: reset }, "Reset") : null;
  return h("div", { className: "card banner warning" }, h("span", {}, text), button);
}

/** One line, or "" when all is well. */
export function troubleOf({ simulation }: Readonly<State>): string {
  if (!simulation) return "";
  if (simulation.warning) return simulation.warning;
  return simulation.converged
    ? ""
    : "The solver stopped before it reached its tolerance: the motion is less accurate than it should be.";
}

function linkBanner(state: LinkState, { retry, reload }: BannerActions): HTMLElement[] {
  switch (state.status) {
    case "open":
      return [];
    case "connecting":
      return [
        h(
          "div",
          { className: "card banner" },
          h("span", { className: "spinner" }),
          h("span", {}, "Connecting to the server …"),
        ),
      ];
    case "waiting":
      return [
        h(
          "div",
          { className: "card banner warning" },
          h(
            "span",
            {},
            state.reason ? `The server says: ${state.reason}. ` : "No connection to the server. ",
            "Trying again in ",
            h("b", { className: "countdown" }),
            " s",
          ),
          h("button", { type: "button", onclick: retry }, "Try now"),
        ),
      ];
    case "locked":
      return [tokenForm(retry)];
    case "incompatible":
      return [
        h(
          "div",
          { className: "card banner error" },
          h("span", {}, `Server and page do not understand each other: ${state.reason}`),
          h("button", { type: "button", onclick: reload }, "Reload"),
        ),
      ];
  }
}

/** The token is handed in for a cookie, which also opens snapshots and recordings; it is never part of an address. */
function tokenForm(retry: () => void): HTMLElement {
  const input = h("input", {
    type: "password",
    autocomplete: "current-password",
    required: true,
    attributes: { "aria-label": "Access token" },
  });
  const note = h("span", {}, "This server wants a token; whoever started it has it.");
  const form = h(
    "form",
    { className: "card banner" },
    note,
    h("span", { className: "field" }, input),
    h("button", { type: "submit" }, "Enter"),
  );
  form.onsubmit = async (event) => {
    event.preventDefault();
    const answer = await fetch("session", { headers: { authorization: `Bearer ${input.value}` } }).catch(() => null);
    if (answer?.ok) retry();
    else note.textContent = answer?.status === 401 ? "That is not the token." : "The server did not answer.";
  };
  return form;
}

export function pill(store: Store): HTMLElement {
  const element = h("span", { className: "pill" });
  const show = () => {
    const { link, simulation, hello, stale, progress, scrub } = store.get();
    const playing = simulation?.playing ?? hello?.playing;
    const [kind, text] =
      link.status !== "open"
        ? (["off", link.status === "locked" ? "locked" : "offline"] as const)
        : progress || stale || !hello
          ? (["busy", "building"] as const)
          : playing
            ? ([scrub === null ? "live" : "paused", scrub === null ? "live" : "looking back"] as const)
            : (["paused", "paused"] as const);
    const viewers = simulation && simulation.viewers > 1 ? ` · ${simulation.viewers} viewers` : "";
    element.dataset["kind"] = kind;
    element.textContent = text + viewers;
  };
  store.watch((s) => s, show);
  return element;
}
