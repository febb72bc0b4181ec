// The worker that holds the connection, begun before all else: it loads while the page's own script, which is far larger, is still
// on its way. It connects when it is told to, so nothing that it says is missed.

export const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module", name: "tetfront socket" });
