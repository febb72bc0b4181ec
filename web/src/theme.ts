// Light or dark: the system's choice until the user makes one, which is remembered.

import type { Store } from "./store";

const KEY = "tetfront.theme";

export function followTheme(store: Store): void {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const chosen = remembered();
  store.set({ dark: chosen ? chosen === "dark" : system.matches });
  system.addEventListener("change", () => {
    if (!remembered()) store.set({ dark: system.matches });
  });
  let first = true;
  store.watch(
    (s) => s.dark,
    (dark) => {
      document.documentElement.dataset["theme"] = dark ? "dark" : "light";
      if (!first && dark !== system.matches) remember(dark ? "dark" : "light");
      else if (!first) remember(null);
      first = false;
    },
  );
}

// Storage may be switched off in the browser; then the choice lasts as long as the page.
function remembered(): string | null {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null;
  }
}

function remember(theme: string | null): void {
  try {
    if (theme) localStorage.setItem(KEY, theme);
    else localStorage.removeItem(KEY);
  } catch {
    return;
  }
}
