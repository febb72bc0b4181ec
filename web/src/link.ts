// The socket's life: connect, hand messages on, come back by itself. Runs in the worker (worker.ts); knows no DOM, so
// tests drive it with a false WebSocket and a false clock.
//
// A slow page must not pile frames up: the link keeps ONE newest frame and hands it on when the page asks for it with
// `ready()`. Everything else is handed on at once and in order. A frame is dropped when a topology of another epoch or a
// model of another generation has passed since.
//
// A dead network closes nothing: a server that plays or owes an answer, but is silent, is asked for a word, and without one the
// connection is over. A simulation may take long for a step; the server's other threads answer meanwhile.

import { encodeAcknowledgement, encodeCommand, parseText, ProtocolError, SUBPROTOCOL } from "./messages";
import { decodeBinary, frameHead } from "./protocol";
import type { Command, TextMessage } from "./messages";
import type { BinaryMessage, Frame } from "./protocol";

/** What the page is told about the connection. */
export type LinkState =
  | { status: "connecting" }
  | { status: "open" }
  | {
      status: "waiting";
      until: number /* Date.now() of the next attempt */;
      attempt: number;
      reason: string; /* or "" */
    }
  | { status: "locked" } // the server wants a token
  | { status: "incompatible"; reason: string };

export type LinkEvent =
  | { kind: "link"; link: LinkState }
  | { kind: "text"; message: TextMessage }
  | { kind: "binary"; message: BinaryMessage; dropped: number /* frames skipped since the last one */ };

export interface LinkOptions {
  url: string;
  emit: (event: LinkEvent) => void;
  open?: (url: string, protocol: string) => WebSocket;
}

const LOCKED = 4001; // the close code of a server that wants a token
const PROTOCOL_ERROR = 1002; // of a server that speaks other versions only
const FULL = 1013; // of a server that has too many clients
const CONNECT_TIMEOUT = 8000; // [ms]
const QUIET = 2500; // [ms] before a server that should speak is asked for a word, and again before it is given up
const LOOK_INTERVAL = 500; // [ms]
const WORD = 0; // the number of that question; the page's begin with 1

/** [ms] before attempt 1, 2, ...: short at first, as a restarted server is back within a second; never above 10 s. */
export const backoff = (attempt: number): number => Math.min(10_000, 500 * 2 ** (attempt - 1));

export class Link {
  private socket: WebSocket | null = null;
  private attempt = 0;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private generation = -1;
  private epoch = -1;
  private surfaceCount = 0; // S of the model
  private frontCount = 0; // N of the topology
  private frame: Frame | null = null;
  private wanted = true; // the page has shown the last frame that it got
  private dropped = 0;
  private acknowledges = false; // the server asks for it
  private passed = -1; // sequence of the last frame that the page got
  private watch: ReturnType<typeof setInterval> | undefined;
  private heard = 0; // [ms] when the server said something, or began to owe it
  private asked: number | null = null; // [ms] when it was asked for a word
  private playing = false;
  private readonly unanswered = new Set<number>();

  constructor(private readonly options: LinkOptions) {}

  /** Connects now, also when it waits for the next attempt. */
  connect(): void {
    if (this.socket) return;
    clearTimeout(this.timer);
    this.options.emit({ kind: "link", link: { status: "connecting" } });
    const open = this.options.open ?? ((url: string, protocol: string) => new WebSocket(url, protocol));
    const socket = open(this.options.url, SUBPROTOCOL);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.generation = this.epoch = -1;
    this.frame = null;
    this.wanted = true;
    this.acknowledges = false;
    this.passed = -1;
    this.playing = false;
    this.unanswered.clear();
    this.asked = null;
    this.timer = setTimeout(() => socket.close(), CONNECT_TIMEOUT);
    socket.onopen = () => {
      clearTimeout(this.timer);
      this.watch = setInterval(() => this.look(), LOOK_INTERVAL);
      this.options.emit({ kind: "link", link: { status: "open" } });
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (this.socket === socket) this.receive(event.data);
    };
    socket.onclose = (event) => {
      if (this.socket !== socket) return;
      if (event.code === LOCKED) this.lock();
      else if (event.code === PROTOCOL_ERROR) this.giveUp(`${event.reason || "the connection broke"}: reload the page`);
      else this.lost(event.code === FULL ? event.reason : "");
    };
  }

  /** False when there is no connection: the command is not kept for later, it would act on a state nobody has seen. */
  send(id: number, command: Command): boolean {
    if (this.socket?.readyState !== 1) return false;
    this.socket.send(encodeCommand(id, command));
    if (!this.owes) this.heard = Date.now();
    if (id !== WORD) this.unanswered.add(id);
    return true;
  }

  /** The page has taken the last frame. */
  ready(): void {
    this.wanted = true;
    this.passFrame();
  }

  /** The page has drawn this frame. Not so while nobody sees it: then the server is not kept busy. */
  drawn(sequence: number): void {
    if (this.acknowledges && sequence <= this.passed && this.socket?.readyState === 1)
      this.socket.send(encodeAcknowledgement(sequence));
  }

  private get owes(): boolean {
    return this.playing || this.unanswered.size > 0;
  }

  private look(): void {
    const now = Date.now();
    if (!this.owes || now - this.heard < QUIET) return;
    if (this.asked === null) {
      this.asked = now;
      this.send(WORD, { command: "scenes" }); // changes nothing, and needs no simulation
    } else if (now - this.asked >= QUIET) {
      this.lost("");
    }
  }

  private receive(data: string | ArrayBuffer): void {
    this.heard = Date.now();
    this.asked = null;
    try {
      if (typeof data === "string") this.receiveText(data);
      else this.receiveBinary(data);
    } catch (error) {
      if (!(error instanceof ProtocolError)) throw error;
      this.giveUp(error.message);
    }
  }

  private receiveText(text: string): void {
    const message = parseText(text);
    if (!message) return;
    if (message.type === "hello") {
      this.attempt = 0;
      this.acknowledges = message.capabilities?.includes("acknowledge") ?? false;
    }
    if (message.type === "hello" || message.type === "state") this.playing = message.playing;
    if ((message.type === "ok" || message.type === "error") && message.id !== null) {
      this.unanswered.delete(message.id);
      if (message.id === WORD) return;
    }
    this.options.emit({ kind: "text", message });
  }

  private receiveBinary(bytes: ArrayBuffer): void {
    // Before it is unpacked: a false count would be a reason to take memory for nothing.
    const head = frameHead(bytes);
    if (head) {
      if (head.generation !== this.generation || head.epoch !== this.epoch) return;
      this.check("frame", head.surface, head.front);
    }
    const message = decodeBinary(bytes);
    if (message.kind === "frame") {
      if (this.frame) ++this.dropped;
      this.frame = message;
      this.passFrame();
      return;
    }
    if (message.kind === "topology" && message.generation !== this.generation) return;
    if (message.kind === "model") {
      this.generation = message.generation;
      this.surfaceCount = message.young.length;
      this.epoch = -1;
    } else {
      this.epoch = message.epoch;
      this.frontCount = message.frontVertices;
      this.check("topology", message.surfaceLevel.length, this.frontCount);
    }
    if (this.frame) ++this.dropped;
    this.frame = null;
    this.options.emit({ kind: "binary", message, dropped: 0 });
  }

  /** What follows a model and a topology must be as large as they say: the viewer writes into arrays of that size. */
  private check(what: string, surface: number, front: number): void {
    if (surface !== this.surfaceCount || front !== this.frontCount)
      throw new ProtocolError(
        `a ${what} has ${surface} surface and ${front} front vertices, not ${this.surfaceCount} and ${this.frontCount}`,
      );
  }

  private passFrame(): void {
    if (!this.frame || !this.wanted) return;
    const { frame, dropped } = this;
    this.frame = null;
    this.wanted = false;
    this.dropped = 0;
    const first = this.passed < 0;
    this.passed = frame.sequence;
    this.options.emit({ kind: "binary", message: frame, dropped });
    // From the first word on the server waits for the next: a page that is opened out of sight may not draw for hours.
    if (first) this.drawn(frame.sequence);
  }

  private lost(reason: string): void {
    this.end();
    const wait = backoff(++this.attempt);
    const { attempt } = this;
    this.options.emit({ kind: "link", link: { status: "waiting", until: Date.now() + wait, attempt, reason } });
    this.timer = setTimeout(() => this.connect(), wait);
  }

  /** Without a token another attempt would end in the same way. */
  private lock(): void {
    this.end();
    this.options.emit({ kind: "link", link: { status: "locked" } });
  }

  /** A server that breaks the protocol will do so again: no further attempt without the user. */
  private giveUp(reason: string): void {
    this.end();
    this.options.emit({ kind: "link", link: { status: "incompatible", reason } });
  }

  private end(): void {
    const { socket } = this;
    this.socket = null; // so that nothing which it still says counts
    clearTimeout(this.timer);
    clearInterval(this.watch);
    socket?.close();
  }
}

/** The buffer to transfer with an event, so that nothing is copied between the threads. */
export const transferOf = (event: LinkEvent): ArrayBuffer[] => {
  if (event.kind !== "binary") return [];
  const { message } = event;
  const array =
    message.kind === "model" ? message.young : message.kind === "topology" ? message.edges : message.surface;
  return [array.buffer as ArrayBuffer];
};
