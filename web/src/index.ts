// What the page loads: the connection's worker, and then the page itself.

import "./styles/index.css";
import "./socket";

import("./main").catch((error: unknown) => {
  const box = document.getElementById("fatal");
  const say = (selector: string, text: string) => box?.querySelector(selector)?.replaceChildren(text);
  say("h2", "The page did not load");
  say("p", "Reload it: the server may be another one by now.");
  say("#fatal-detail", String(error));
  box?.removeAttribute("hidden");
});
