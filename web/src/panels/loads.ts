// Forces that stay and pins, as a list: each force's newtons can be typed, in all or along each axis, and it can be removed.

import type { Command, Force, Vec3 } from "../messages";
import { can } from "../store";
import type { Store } from "../store";
import { h, icon } from "./dom";
import { group, toolButton } from "./fields";

export function loads(store: Store, send: (command: Command) => void): HTMLElement {
  const list = h("ul", { className: "loads" });
  const hint = h("p", { className: "note" });
  const tools = h(
    "div",
    { className: "row wrap" },
    toolButton(store, "pin", "Pin", "A tap on the object pins that part, or lets it go (P)"),
  );
  const element = group("Forces and pins", true, list, hint, tools);
  store.watch(
    (s) => s.settings,
    (settings) => {
      const forces = settings?.forces ?? [];
      const held = settings?.pins.filter(({ pinned }) => pinned).length ?? 0;
      // A field that is being typed into stays.
      if (!list.contains(document.activeElement)) list.replaceChildren(...forces.map((force) => row(force)));
      hint.textContent =
        forces.length + held === 0
          ? "Shift-drag the object, or press N over it, for a force that stays; P pins what is under the pointer."
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
    const name = `Force ${force.force + 1}`;
    const size = Math.hypot(...force.value);
    const move = (value: Vec3) => send({ command: "force_move", force: force.force, value });
    const field = (value: number, label: string, change: (typed: number) => void) => {
      const input = h("input", {
        type: "number",
        step: "any",
        min: "-1e9",
        max: "1e9",
        // A component that is there by rounding only is none.
        value: String(Math.abs(value) > 1e-6 * size ? Number(value.toPrecision(3)) : 0),
        onchange: () => {
          const valid = input.value !== "" && input.reportValidity();
          const typed = Number(input.value);
          input.blur(); // the server's answer comes into the list, which stays while one types
          if (valid) change(typed);
        },
        onfocus: () => store.set({ selectedForce: force.force }),
        attributes: { "aria-label": label },
      });
      return input;
    };
    const whole = field(size, `${name} in newtons`, (typed) => {
      if (typed > 0 && size > 0) move(force.value.map((x) => (x * typed) / size) as unknown as Vec3);
    });
    const along = force.value.map((component, i) =>
      field(component, `${name} along ${"xyz"[i]} in newtons`, (typed) =>
        move(force.value.map((x, k) => (k === i ? typed : x)) as unknown as Vec3),
      ),
    );
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
      {},
      h(
        "div",
        { className: "row" },
        name,
        h("span", { className: "field" }, whole, h("span", { className: "suffix" }, "N")),
        remove,
      ),
      h(
        "div",
        { className: "row three" },
        ...along.map((input, i) =>
          h("label", { className: "field" }, h("span", { className: "axis" }, "xyz"[i]), input),
        ),
      ),
    );
    item.dataset["force"] = String(force.force);
    item.classList.toggle("selected", store.get().selectedForce === force.force);
    return item;
  }
  return element;
}
