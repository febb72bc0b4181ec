// Short messages about something that did not work. The same message again counts up instead of piling up.

import { h, icon } from "./dom";

const STAY = 7000; // [ms]

export class Toasts {
  readonly element = h("div", { className: "toasts", attributes: { role: "alert" } });
  private readonly shown = new Map<
    string,
    { count: number; badge: HTMLElement; timer: ReturnType<typeof setTimeout>; remove: () => void }
  >();

  show(text: string, kind: "problem" | "info" = "problem"): void {
    const known = this.shown.get(text);
    if (known) {
      clearTimeout(known.timer);
      known.badge.textContent = ` ×${++known.count}`;
      known.timer = setTimeout(known.remove, STAY);
      return;
    }
    const badge = h("b");
    const remove = () => {
      clearTimeout(entry.timer); // or it would end a later toast of the same text
      toast.remove();
      this.shown.delete(text);
    };
    const close = h(
      "button",
      { type: "button", className: "icon small", onclick: remove, attributes: { "aria-label": "Dismiss" } },
      icon("close"),
    );
    const toast = h("div", { className: `card toast ${kind}` }, h("span", {}, text, badge), close);
    this.element.append(toast);
    const entry = { count: 1, badge, timer: setTimeout(remove, STAY), remove };
    this.shown.set(text, entry);
  }
}
