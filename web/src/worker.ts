// The socket lives here, on a thread of its own: a page that draws slowly would starve it (see link.ts).

import { Link, transferOf } from "./link";
import type { Command } from "./messages";

export type WorkerRequest =
  | { kind: "connect"; url?: string } // the first one carries the address
  | { kind: "ready" }
  | { kind: "drawn"; sequence: number }
  | { kind: "command"; id: number; command: Command };

let link: Link | undefined;

self.onmessage = ({ data }: MessageEvent<WorkerRequest>) => {
  if (data.kind === "connect") {
    link ??= new Link({
      url: data.url ?? "",
      emit: (event) => self.postMessage(event, { transfer: transferOf(event) }),
    });
    link.connect();
  } else if (data.kind === "ready") {
    link?.ready();
  } else if (data.kind === "drawn") {
    link?.drawn(data.sequence);
  } else {
    link?.send(data.id, data.command);
  }
};
