// Forces that stay and pins, as a list: each force's newtons can be typed, and it can be removed.

import { significant } from "../format";
import type { Command, Force, Vec3 } from "../messages";
import { can } from "../store";
import type { Store } from "../store";
import { h, icon } from "./dom";
import { group } from "./fields";

export function loads(store: Store, send: (command: Command) => void): HTMLElement {
  const list = h("ul", { className: "loads" });
  const hint = h("p", { className: "note" });
  const element = group("Forces and pins", true, list, hint);
  store.watch(
    (s) => s.settings,
    (settings) => {
      const forces = settings?.forces ?? [];
      const held = settings?.pins.filter(({ pinned }) => pinned).length ?? 0;
      // A field that is being typed into stays.
      if (!list.contains(document.activeElement)) list.replaceChildren(...forces.map((force) => row(force)));
      hint.textContent =
        forces.length + held === 0
          ? "Shift-drag the object for a force that stays; P pins what is under the pointer."
          : held > 0
            ? `${held} ${held === 1 ? "place is" : "places are"} pinned; P there lets it go.`
            : "";
      hint.hidden = hint.textContent === "";
    },
  );
  store.watch(
    (s) => can(s, "edit"),
    (on) => (element.hidden = !on),
  );
  store.watch(
    (s) => s.selectedForce,
    (selected) =>
      list
        .querySelectorAll("li")
        .forEach((item) => item.classList.toggle("selected", item.dataset["force"] === String(selected))),
  );

  function row(force: Force): HTMLElement {
    const size = Math.hypot(...force.value);
    const input = h("input", {
      type: "number",
      step: "any",
      min: "0",
      max: "1e9",
      value: significant(size).replace("−", "-"),
      onchange: () => {
        const wanted = Number(input.value);
        input.blur();
        if (!(wanted > 0) || size === 0) return;
        const value = force.value.map((x) => (x * wanted) / size) as unknown as Vec3;
        send({ command: "force_move", force: force.force, value });
      },
      onfocus: () => store.set({ selectedForce: force.force }),
      attributes: { "aria-label": `Force ${force.force + 1} in newtons` },
    });
    const remove = h(
      "button",
      {
        type: "button",
        className: "icon small",
        onclick: () => send({ command: "force_remove", force: force.force }),
        attributes: { "aria-label": `Remove force ${force.force + 1}` },
      },
      icon("close"),
    );
    const item = h(
      "li",
      { className: "row" },
      `Force ${force.force + 1}`,
      h("span", { className: "field" }, input, h("span", { className: "suffix" }, "N")),
      remove,
    );
    item.dataset["force"] = String(force.force);
    return item;
  }
  return element;
}
