// Keeps the page's address and what it shows the same (share.ts): takes over the link with which the page was opened, or that was
// pasted into it, and writes what the user has changed since. A link for another scene waits until that scene is there.

import type { Command } from "./messages";
import { fromFragment, toFragment } from "./share";
import type { Shared } from "./share";
import { can, colouringsOf, isOpen, viewOf } from "./store";
import type { Store } from "./store";
import type { CameraRig } from "./viewer/camera";

export interface AddressParts {
  store: Store;
  rig: Pick<CameraRig, "place" | "moved">;
  send: (command: Command) => void;
  tell: (message: string) => void;
}

const PATIENCE = 500; // [ms] after a change: others may follow

/** Returns what is to be called when something has changed that the store does not know of. */
export function shareByAddress({ store, rig, send, tell }: AddressParts): () => void {
  let pending: Shared | null = fromFragment(location.hash);
  let waits = false; // the pending link is for a scene that is not served
  let kept: string | null = null; // what would have been written first instead of it

  /** What there is to write; null while the server has not said all. */
  const known = (): string | null => {
    const state = store.get();
    return isOpen(state) && state.simulation && state.settings ? toFragment(state, rig.moved) : null;
  };
  const take = () => {
    const { hello } = store.get();
    if (!pending || !hello || !isOpen(store.get())) return;
    const { scene, view, camera, commands } = pending;
    if (scene !== "" && scene !== hello.scene.name) {
      if (!waits) tell(`This link is for the scene ${scene}${can(store.get(), "load") ? "; open it with O" : ""}`);
      waits = true;
      kept = known();
      return;
    }
    pending = null;
    waits = false;
    const offered = colouringsOf(hello).some(({ value }) => value === view.colouring);
    store.set({ ...viewOf(hello), ...view, ...(offered ? {} : { colouring: viewOf(hello).colouring }) });
    const { eye, target } = (scene === "" ? null : camera) ?? hello.view;
    rig.place(eye, target);
    if (scene !== "") commands.forEach(send);
  };

  let timer: ReturnType<typeof setTimeout> | undefined;
  const write = () => {
    timer = undefined;
    const fragment = known();
    if (fragment === null) return;
    // A link that could not be taken over stays until the user has changed something.
    if (waits && fragment === (kept ??= fragment)) return;
    pending = null;
    waits = false;
    const page = location.pathname + location.search;
    const wanted = page + (fragment ? `#${fragment}` : "");
    if (wanted !== page + location.hash) history.replaceState(null, "", wanted);
  };
  const soon = () => void (timer ??= setTimeout(write, PATIENCE));

  store.watch((s) => (isOpen(s) ? s.hello : null), take);
  store.watch((s) => s, soon);
  addEventListener("hashchange", () => {
    pending = fromFragment(location.hash);
    waits = false;
    take();
  });
  return soon;
}
