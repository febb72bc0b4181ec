// Forces that stay and pins, as a list: each force's newtons can be typed, in all or along each axis, and it can be removed.

import type { Command, Force, Vec3 } from "../messages";
import { can } from "../store";
import type { Store } from "../store";
import { h, icon } from "./dom";
import { follow, group, toolButton } from "./fields";

interface Row {
  element: HTMLElement;
  remove: HTMLButtonElement;
  show: (force: Force) => void;
}

const LEAST = 1e-6; // [N] of a force as a whole: none is removed

export function loads(store: Store, send: (command: Command) => void): HTMLElement {
  const rows = new Map<number, Row>();
  const list = h("ul", { className: "loads" });
  const hint = h("p", { className: "note" });
  const tools = h(
    "div",
    { className: "row wrap" },
    toolButton(store, "pin", "Pin", "A tap on the object pins that part, or lets it go (P)"),
    toolButton(store, "force", "Force", "A tap on the object puts a force there that stays (N)"),
  );
  const element = group("Forces and pins", true, list, hint, tools);
  follow(
    store,
    (s) => s.settings,
    () => {
      const { settings } = store.get();
      const forces = settings?.forces ?? [];
      const held = settings?.pins.filter(({ pinned }) => pinned).length ?? 0;
      showRows(forces);
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

  /** Rows of forces that stay keep the focus, and what is being typed into them. */
  function showRows(forces: readonly Force[]): void {
    const active = [...rows.values()].findIndex(({ element }) => element.contains(document.activeElement));
    for (const [number, { element }] of rows)
      if (!forces.some(({ force }) => force === number)) {
        element.remove();
        rows.delete(number);
      }
    for (const force of forces) {
      const known = rows.get(force.force) ?? row(force);
      if (!rows.has(force.force)) list.append(known.element);
      rows.set(force.force, known);
      known.show(force);
    }
    if (active < 0 || list.contains(document.activeElement)) return;
    const left = [...rows.values()];
    (left[Math.min(active, left.length - 1)]?.remove ?? element.querySelector("summary"))?.focus();
  }

  function row(first: Force): Row {
    let now = first;
    const name = `Force ${first.force + 1}`;
    const size = () => Math.hypot(...now.value);
    const move = (value: Vec3) => send({ command: "force_move", force: now.force, value });
    const field = (label: string, low: number, read: () => number, change: (typed: number) => void) => {
      let typing = false;
      const show = () => {
        if (!typing) input.value = String(Number(read().toPrecision(3)));
      };
      const input = h("input", {
        type: "number",
        step: "any",
        min: String(low),
        max: "1e9",
        oninput: () => (typing = true),
        onchange: () => {
          typing = false;
          if (input.value !== "" && input.reportValidity()) change(Number(input.value));
          else show();
        },
        onblur: () => {
          if (!typing) return; // and nothing has been changed
          typing = false;
          show();
        },
        onfocus: () => store.set({ selectedForce: now.force }),
        attributes: { "aria-label": label },
      });
      return { input, show };
    };
    const whole = field(`${name} in newtons`, LEAST, size, (typed) => {
      // A force of nothing has no direction that it could grow in.
      if (size() > 0) move(now.value.map((x) => (x * typed) / size()) as unknown as Vec3);
      else whole.show();
    });
    const along = [0, 1, 2].map((i) =>
      field(
        `${name} along ${"xyz"[i]} in newtons`,
        -1e9,
        // A component that is there by rounding only is none.
        () => (Math.abs(now.value[i]) > 1e-6 * size() ? now.value[i] : 0),
        (typed) => move(now.value.map((x, k) => (k === i ? typed : x)) as unknown as Vec3),
      ),
    );
    const remove = h(
      "button",
      {
        type: "button",
        className: "icon small",
        onclick: () => send({ command: "force_remove", force: now.force }),
        attributes: { "aria-label": `Remove force ${now.force + 1}` },
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
        h("span", { className: "field" }, whole.input, h("span", { className: "suffix" }, "N")),
        remove,
      ),
      h(
        "div",
        { className: "row three" },
        ...along.map(({ input }, i) =>
          h("label", { className: "field" }, h("span", { className: "axis" }, "xyz"[i]), input),
        ),
      ),
    );
    item.dataset["force"] = String(first.force);
    item.classList.toggle("selected", store.get().selectedForce === first.force);
    const show = (force: Force) => {
      now = force;
      for (const field of [whole, ...along]) field.show();
    };
    return { element: item, remove, show };
  }
  return element;
}
