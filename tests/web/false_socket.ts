// A WebSocket that does what a test says, a link over it, and the least that a server says first.

import { vi } from "vitest";

import { Link } from "../../web/src/link";
import type { LinkEvent } from "../../web/src/link";

export class FalseSocket {
  static all: FalseSocket[] = [];
  readyState = 0;
  binaryType = "";
  sent: string[] = [];
  onopen: (() => void) | null = null;
  onclose: ((event: { code: number; reason: string }) => void) | null = null;
  onmessage: ((event: { data: unknown }) => void) | null = null;
  constructor(
    readonly url: string,
    readonly protocol: string,
  ) {
    FalseSocket.all.push(this);
  }
  open() {
    this.readyState = 1;
    this.onopen?.();
  }
  receive(...messages: unknown[]) {
    for (const data of messages) this.onmessage?.({ data });
  }
  send(text: string) {
    this.sent.push(text);
  }
  close(code = 1006, reason = "") {
    this.readyState = 3;
    this.onclose?.({ code, reason });
  }
}

export const hello = {
  ...{
    type: "hello",
    protocol: 1,
    version: "0",
    scene: { name: "a", title: "A" },
    up: 2,
    depth: 1,
    young_range: [1, 1],
  },
  ...{ rest_box: [0, 0, 0, 1, 1, 1], view: {}, gravity: [0, 0, 0], tolerance: 0.1, time_step: 0.01, order: 1 },
  ...{ playing: true, speed: 1, limits: { message_bytes: 65536 } },
};

export const socket = () => FalseSocket.all.at(-1)!;

/** With a false clock; it has begun to connect. */
export function falseLink(): { link: Link; events: LinkEvent[] } {
  vi.useFakeTimers();
  FalseSocket.all = [];
  const events: LinkEvent[] = [];
  const link = new Link({
    url: "ws://host/ws",
    emit: (event) => events.push(event),
    open: (url, protocol) => new FalseSocket(url, protocol) as unknown as WebSocket,
  });
  link.connect();
  return { link, events };
}

/** What the page was told of the connection. */
export const statuses = (events: readonly LinkEvent[]) =>
  events.flatMap((event) => (event.kind === "link" ? [event.link.status] : []));
