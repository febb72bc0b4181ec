// The worker that holds the connection, begun before all else: it loads while the page's own script, which is far larger, is still
// on its way. It connects when it is told to, so nothing that it says is missed.

import { missing } from "./fatal";

export const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module", name: "tetfront socket" });

// Listened to from the beginning: that its script is missing may be known before the page's own script is there. Such an event has
// no message; exceptions have one, and main.ts shows it.
worker.addEventListener("error", ({ message }: Partial<ErrorEvent>) => {
  if (!message) missing("The script of the connection could not be loaded.");
});
