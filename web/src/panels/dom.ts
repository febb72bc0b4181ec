// Small helpers to build elements. Styles set here go through the CSSOM, which a strict style-src allows.

type Child = Node | string | null;
type Props<T extends keyof HTMLElementTagNameMap> = Partial<Omit<HTMLElementTagNameMap[T], "style" | "attributes">> & {
  attributes?: Record<string, string>;
};

/** h("button", { className: "primary", onclick }, "Play") */
export function h<T extends keyof HTMLElementTagNameMap>(
  tag: T,
  { attributes = {}, ...props }: Props<T> = {} as Props<T>,
  ...children: Child[]
): HTMLElementTagNameMap[T] {
  const element = Object.assign(document.createElement(tag), props);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** The element with this id of index.html. */
export function byId<T extends HTMLElement = HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`index.html has no #${id}`);
  return element as T;
}

const PATHS = {
  play: "M8 5.2v13.6c0 .8.9 1.3 1.6.8l10-6.8a1 1 0 0 0 0-1.6l-10-6.8C8.900 4 8 4.400 8 5.200z",
  pause: "M7 5h3.500v14H7zM13.500 5H17v14h-3.500z",
  step: "M6 5.500v13l9-6.500zM16 5.500h2.500v13H16z",
  reset: "M12 5V1.800L7 6l5 4.200V7a5.500 5.500 0 1 1-5.500 5.500h-2A7.500 7.500 0 1 0 12 5z",
  help: "M11 17h2.200v2.200H11zM12 4.500c-2.600 0-4.400 1.600-4.600 4h2.200c.1-1.200 1-2 2.400-2s2.300.8 2.300 1.900c0 1-.5 1.500-1.500 2.200-1.200.8-1.800 1.700-1.800 3.200v.9h2.100v-.7c0-1 .4-1.500 1.500-2.200 1.300-.9 2-1.900 2-3.400 0-2.300-1.900-3.900-4.600-3.900z",
  theme: "M12 3a9 9 0 1 0 0 18zm0-1a10 10 0 1 1 0 20 10 10 0 0 1 0-20z",
  panel:
    "M4 6.500h9v1.800H4zm12 0h4v1.800h-4zM13 4.800h2v5.200h-2zM4 15.700h4v1.800H4zm7 0h9v1.800h-9zM8 14h2v5.200H8z",
  close:
    "M6.400 5 5 6.400 10.600 12 5 17.600 6.400 19l5.600-5.600 5.600 5.600 1.400-1.400-5.600-5.600L19 6.400 17.600 5 12 10.600z",
  home: "M4 9V4h5v2H6v3zm16 0h-2V6h-3V4h5zM4 15h2v3h3v2H4zm14 3v-3h2v5h-5v-2zM12 9a3 3 0 1 1 0 6 3 3 0 0 1 0-6z",
  plots: "M4 4h1.800v14.200H20V20H4zM8 16l3.200-5 3 2.600L18.500 7l1.500 1-5.400 8.200-3-2.600L9.500 17z",
  scenes: "M4 5h7v6H4zm9 0h7v6h-7zM4 13h7v6H4zm9 0h7v6h-7z",
  camera:
    "M9 5l-1.500 2H5a1.500 1.500 0 0 0-1.500 1.500v9A1.500 1.500 0 0 0 5 19h14a1.500 1.500 0 0 0 1.500-1.500v-9A1.500 1.500 0 0 0 19 7h-2.500L15 5zm3 4.500a3.500 3.500 0 1 1 0 7 3.500 3.500 0 0 1 0-7z",
  record: "M12 5.500a6.500 6.500 0 1 1 0 13 6.500 6.500 0 0 1 0-13z",
} as const;
export type IconName = keyof typeof PATHS;

export function icon(name: IconName): SVGSVGElement {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS(space, "path");
  path.setAttribute("d", PATHS[name]);
  svg.append(path);
  return svg;
}

/** A round button with an icon; `key` is shown in its tooltip. */
export function iconButton(name: IconName, label: string, key: string, onclick: () => void): HTMLButtonElement {
  return h(
    "button",
    { type: "button", className: "icon", title: `${label} (${key})`, onclick, attributes: { "aria-label": label } },
    icon(name),
  );
}

/** At most one call in `wait` milliseconds, the last one always. */
export function throttle<A extends unknown[]>(wait: number, call: (...args: A) => void): (...args: A) => void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let latest: A | null = null;
  const run = () => {
    timer = undefined;
    if (!latest) return;
    const args = latest;
    latest = null;
    timer = setTimeout(run, wait);
    call(...args);
  };
  return (...args) => {
    latest = args;
    if (timer === undefined) run();
  };
}
