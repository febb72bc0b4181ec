// Parts of the object that are stiffer or softer than the scene says, as a list that all viewers share: each factor can be typed,
// each part taken back. Above it the tools that make them, for those without a keyboard, and the size of what they take.

import { quantityOfLength } from "../format";
import type { StiffnessPart } from "../messages";
import type { PartEdits } from "../part_edits";
import { effective, keyOf } from "../parts";
import { canScaleParts, initialState } from "../store";
import type { Store } from "../store";
import { h, icon } from "./dom";
import { group, numberRow, toolButton } from "./fields";

interface Row {
  element: HTMLElement;
  remove: HTMLButtonElement;
  show: (part: StiffnessPart, index: number) => void;
  refresh: () => void; // shows what is so
}

export function parts(store: Store, edits: PartEdits): HTMLElement {
  const rows = new Map<string, Row>();
  const list = h("ul", { className: "loads parts" });
  const clear = h(
    "button",
    { type: "button", onclick: () => edits.clear(), title: "All parts as stiff as the scene says" },
    "Remove all",
  );
  const hint = h("p", { className: "note" }, "K makes stiffer what is under the pointer, Shift K softer.");
  const stiffer = toolButton(store, "stiffer", "Stiffer", "A tap on the object makes that part stiffer (K)");
  const element = group(
    "Stiffer and softer parts",
    true,
    h(
      "div",
      { className: "row wrap" },
      toolButton(store, "softer", "Softer", "A tap on the object makes that part softer (Shift K)"),
      stiffer,
    ),
    regionSize(store),
    list,
    clear,
    hint,
  );
  store.watch(canScaleParts, (able) => (element.hidden = !able));
  store.watch(
    (s) => s.settings?.stiffness_parts,
    (told) => {
      const shown = effective(told ?? []);
      const keys = shown.map(keyOf);
      shown.forEach((part) => rows.set(keyOf(part), rows.get(keyOf(part)) ?? row(part)));
      for (const key of rows.keys()) if (!keys.includes(key)) rows.delete(key);
      const wanted = keys.map((key) => (rows.get(key) as Row).element);
      // Rows that stay where they are keep the focus, and what is being typed into them.
      if (wanted.length !== list.children.length || wanted.some((item, i) => item !== list.children[i])) {
        const active = document.activeElement;
        const at = [...list.children].findIndex((item) => item.contains(active));
        for (const item of [...list.children]) if (!wanted.includes(item as HTMLElement)) item.remove();
        wanted.forEach((item, i) => item !== list.children[i] && list.insertBefore(item, list.children[i] ?? null));
        if (at >= 0 && document.activeElement !== active) {
          const next = rows.get(keys[Math.min(at, keys.length - 1)])?.remove ?? stiffer;
          (list.contains(active) ? (active as HTMLElement) : next).focus();
        }
      }
      shown.forEach((part, i) => rows.get(keys[i])?.show(part, i));
      clear.hidden = shown.length < 2;
      hint.hidden = shown.length > 0;
    },
  );

  store.watch(
    (s) => s.refusals,
    () => rows.forEach(({ refresh }) => refresh()),
  );

  function row(part: StiffnessPart): Row {
    const name = h("span");
    const input = h("input", {
      type: "number",
      step: "any",
      min: "0.01",
      max: "100",
      onchange: () => {
        if (input.value !== "" && input.reportValidity()) edits.set(part, Number(input.value));
        else show();
      },
    });
    const remove = h(
      "button",
      { type: "button", className: "icon small", onclick: () => edits.set(part, 1) },
      icon("close"),
    );
    let value = part.value;
    const show = () => (input.value = String(Number(value.toPrecision(3))));
    const size = h("small", {}, ` ${quantityOfLength(part.radius)}`);
    return {
      element: h(
        "li",
        { className: "row" },
        h("span", { className: "name" }, name, size),
        h("span", { className: "field" }, h("span", { className: "axis" }, "×"), input),
        remove,
      ),
      remove,
      refresh: show,
      show: (now, index) => {
        if (now.value !== value || input.value === "") {
          value = now.value;
          show();
        }
        name.textContent = `Part ${index + 1}`;
        input.setAttribute("aria-label", `Part ${index + 1}, times the scene's stiffness`);
        remove.setAttribute("aria-label", `Remove part ${index + 1}`);
      },
    };
  }
  return element;
}

function regionSize(store: Store): HTMLElement {
  return numberRow(store, {
    label: "Region",
    unit: "%",
    spoken: "percent of the object's diagonal",
    title: "Radius of what is made stiffer or softer, or pinned, in percent of the object's diagonal ([ and ])",
    low: 0.5,
    high: 50,
    slider: "logarithmic",
    local: true,
    now: (s) => s.regionSize,
    scene: () => initialState.regionSize,
    change: (value) => value !== null && store.set({ regionSize: value }),
  });
}
