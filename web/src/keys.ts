// The keyboard: one table makes both the behaviour and the help sheet.

import type { Actions } from "./actions";

export interface Binding {
  keys: readonly string[]; // KeyboardEvent.key, lower case; "shift+" in front where Shift matters
  label: string; // on the help sheet
  what: string;
  run: (key: string) => void;
  /** Goes before the others while a pull is held by keys. */
  whilePulling?: true;
}

/** What belongs to the page rather than to the simulation. */
export interface PageActions {
  help: () => void;
  plots: () => void;
  scenes: () => void;
  snapshot: (source: "server" | "canvas") => void;
}

// Steps to the right, up and towards the viewer.
const WAYS: Record<string, [number, number, number]> = {
  arrowleft: [-1, 0, 0],
  arrowright: [1, 0, 0],
  arrowup: [0, 1, 0],
  arrowdown: [0, -1, 0],
};
// Where they are on a number block.
const PANS: Record<string, [number, number]> = { 4: [-1, 0], 6: [1, 0], 8: [0, 1], 2: [0, -1] };
const DEPTHS: Record<string, number> = { pageup: 1, pagedown: -1 };

export function bindings(actions: Actions, page: PageActions): Binding[] {
  return [
    { keys: [" "], label: "Space", what: "Play or pause", run: actions.togglePlay },
    { keys: ["arrowright"], label: "→", what: "One step (pauses)", run: actions.step },
    { keys: ["r"], label: "R", what: "Reset to the rest shape", run: actions.reset },
    { keys: ["+", "="], label: "+", what: "Faster", run: () => actions.faster(1) },
    { keys: ["-"], label: "−", what: "Slower", run: () => actions.faster(-1) },
    { keys: ["c"], label: "C", what: "Next colouring", run: actions.nextColouring },
    { keys: ["w"], label: "W", what: "Wireframe of the front", run: actions.toggleWireframe },
    { keys: ["e"], label: "E", what: "Surface, or solid tets of the front", run: actions.toggleTets },
    { keys: ["x"], label: "X", what: "Cut open, or whole", run: actions.toggleCut },
    { keys: ["p"], label: "P", what: "Pin what is under the pointer, or let it go", run: () => actions.pin() },
    {
      keys: ["shift+p"],
      label: "Shift P",
      what: "Let it go, also what the scene has pinned",
      run: () => actions.pin(false),
    },
    { keys: ["k"], label: "K", what: "What is under the pointer becomes stiffer", run: () => actions.stiffen(1) },
    { keys: ["shift+k"], label: "Shift K", what: "Softer", run: () => actions.stiffen(-1) },
    { keys: ["[", ","], label: "[", what: "K and P take a smaller region", run: () => actions.resizeRegion(-1) },
    { keys: ["]", "."], label: "]", what: "A larger one", run: () => actions.resizeRegion(1) },
    { keys: ["escape"], label: "Esc", what: "Put the tool down that a button has given", run: actions.putDown },
    { keys: ["n"], label: "N", what: "A new force on what is under the pointer", run: actions.newForce },
    { keys: ["delete", "backspace"], label: "Delete", what: "Remove the selected force", run: actions.removeForce },
    { keys: ["d"], label: "D", what: "Pull what is under the pointer, by keys", run: actions.grab },
    {
      keys: Object.keys(WAYS),
      label: "← → ↑ ↓",
      what: "Then: move the hand in the plane of the picture",
      run: (key) => actions.movePull(...WAYS[key]),
      whilePulling: true,
    },
    {
      keys: Object.keys(DEPTHS),
      label: "Page up, down",
      what: "Then: the hand nearer or farther",
      run: (key) => actions.movePull(0, 0, DEPTHS[key]),
      whilePulling: true,
    },
    { keys: ["enter", "escape"], label: "Enter, Esc", what: "Then: let go", run: actions.letGo, whilePulling: true },
    { keys: ["s"], label: "S", what: "Picture, drawn by the server", run: () => page.snapshot("server") },
    { keys: ["shift+s"], label: "Shift S", what: "Picture of this canvas", run: () => page.snapshot("canvas") },
    { keys: ["v"], label: "V", what: "Start or end a recording", run: actions.toggleRecording },
    { keys: ["l"], label: "L", what: "Back to the present", run: actions.live },
    { keys: ["o"], label: "O", what: "Open another scene", run: page.scenes },
    { keys: ["g"], label: "G", what: "Plots", run: page.plots },
    { keys: ["f"], label: "F", what: "Whole object in view", run: actions.home },
    { keys: ["t"], label: "T", what: "Light or dark", run: actions.toggleTheme },
    { keys: ["shift+arrowleft"], label: "Shift ←", what: "Orbit left", run: () => actions.orbit(-1, 0) },
    { keys: ["shift+arrowright"], label: "Shift →", what: "Orbit right", run: () => actions.orbit(1, 0) },
    { keys: ["shift+arrowup"], label: "Shift ↑", what: "Orbit up", run: () => actions.orbit(0, -1) },
    { keys: ["shift+arrowdown"], label: "Shift ↓", what: "Orbit down", run: () => actions.orbit(0, 1) },
    { keys: ["pageup"], label: "Page up", what: "Nearer", run: () => actions.zoom(1 / 1.15) },
    { keys: ["pagedown"], label: "Page down", what: "Farther", run: () => actions.zoom(1.15) },
    {
      keys: Object.keys(PANS),
      label: "4 6 8 2",
      what: "Move the view; without a pointer keys mean its middle",
      run: (key) => actions.pan(...PANS[key]),
    },
    { keys: ["?", "h"], label: "?", what: "This sheet", run: page.help },
  ];
}

/** Keys that act again while they are held. */
const REPEATS = [...Object.keys(WAYS), ...Object.keys(DEPTHS), ...Object.keys(PANS), "+", "=", "-", "[", "]", ",", "."];

/** The hands' part of the help sheet. */
export const GESTURES = [
  ["Drag the object", "Pull it"],
  ["Shift-drag the object", "A force that stays; drag its arrow's head to change it, its foot to move it"],
  ["Drag beside it, or right drag", "Orbit"],
  ["Wheel, or two fingers", "Zoom"],
  ["Middle drag, or two fingers", "Move the view"],
  ["Pin, Force, Stiffer, Softer in the panel", "A tap on the object does that, without keys"],
  ["Double-click", "Look at that point; beside the object: the whole"],
] as const;

export function findBinding(
  table: readonly Binding[],
  event: Pick<KeyboardEvent, "key" | "shiftKey" | "ctrlKey" | "metaKey" | "altKey">,
  pulling = false,
): Binding | undefined {
  if (event.ctrlKey || event.metaKey || event.altKey) return undefined;
  const key = event.key.toLowerCase();
  const find = (name: string, whilePulling = false) =>
    table.find((binding) => binding.keys.includes(name) && (binding.whilePulling ?? false) === whilePulling);
  // Shift is part of typing "?" or "+", but means something else with an arrow and where a key has a second meaning.
  const shifted = event.shiftKey ? find(`shift+${key}`) : undefined;
  if (shifted || (event.shiftKey && key.startsWith("arrow"))) return shifted;
  return (pulling ? find(key, true) : undefined) ?? find(key);
}

const PRESS = [" ", "Enter"];
const ARROWS = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown"];

/** Of an element that has the focus, and of inputs their type: the keys that it takes for itself; null: all. */
export function ownKeys(element: string, type: string): readonly string[] | null {
  switch (element) {
    case "select":
    case "textarea":
      return null;
    case "button":
    case "a":
    case "summary":
      return PRESS;
    case "input":
      if (type === "range") return [...ARROWS, "PageUp", "PageDown", "Home", "End"];
      return type === "radio" ? [...ARROWS, " "] : type === "checkbox" ? [" "] : null;
    default:
      return [];
  }
}

/** Keys typed into a field, or that press what has the focus, are not shortcuts. */
export function isTyping(target: EventTarget | null, key: string): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target.closest("dialog")) return true;
  const own = ownKeys(target.localName, target instanceof HTMLInputElement ? target.type : "");
  return own === null || own.includes(key);
}

/** What was used with the pointer gives the focus back, or it would take the next keys for itself; a field that is typed into keeps it. */
export function leaveToShortcuts(parent: HTMLElement): void {
  const blur = (target: EventTarget | null, which: string) => {
    if (target instanceof Element) target.closest<HTMLElement>(which)?.blur();
  };
  let pointed = false; // the last thing done there
  parent.addEventListener("pointerdown", () => (pointed = true));
  parent.addEventListener("click", ({ detail, target }) => detail > 0 && blur(target, "button, summary, [type=range]"));
  // Of a slider that was dragged, and of a choice.
  parent.addEventListener(
    "change",
    ({ target }) => pointed && blur(target, "select, [type=range], [type=radio], [type=checkbox]"),
  );
  // Of a list that was opened and closed again: while it is open, keys do not come here.
  parent.addEventListener("keydown", ({ target }) => {
    if (pointed) blur(target, "select");
    pointed = false;
  });
}

export function listen(table: readonly Binding[], pulling: () => boolean): void {
  document.addEventListener("keydown", (event) => {
    if (isTyping(document.activeElement, event.key)) return;
    const binding = findBinding(table, event, pulling());
    if (!binding || (event.repeat && !REPEATS.includes(event.key.toLowerCase()))) return;
    event.preventDefault();
    binding.run(event.key.toLowerCase());
  });
}
