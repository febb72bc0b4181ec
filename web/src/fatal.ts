// Says in the middle of the page why there is nothing to see. It is in the page's HTML, so it needs none of the scripts that may be missing.

export function fatal(title: string, advice: string, detail: string): void {
  const box = document.getElementById("fatal");
  const say = (selector: string, text: string) => box?.querySelector(selector)?.replaceChildren(text);
  say("h2", title);
  say("p", advice);
  say("#fatal-detail", detail);
  box?.removeAttribute("hidden");
}

/** A part of the page is not there. */
export const missing = (detail: string): void =>
  fatal("The page did not load", "Reload it: the server may be another one by now.", detail);
