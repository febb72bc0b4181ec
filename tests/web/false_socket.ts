// A WebSocket that does what a test says, and the least that a server says first.

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
