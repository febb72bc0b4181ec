// The page's end of the worker: puts what the server says into the store, hands binary data to the viewer, numbers the
// commands and matches the answers.

import type { LinkEvent } from "./link";
import type { Answer, Command, Hello, Refusal, TextMessage } from "./messages";
import type { BinaryMessage } from "./protocol";
import { isOpen, viewOf } from "./store";
import type { Store } from "./store";
import type { WorkerRequest } from "./worker";

/** A worker, or something that behaves like one. */
export interface Port {
  postMessage(request: WorkerRequest): void;
  onmessage: ((event: MessageEvent<LinkEvent>) => void) | null;
}

export interface ConnectionEvents {
  binary: (message: BinaryMessage) => void;
  /** The server refused a command, or it could not be sent. */
  refused: (command: Command | null, message: string) => void;
  /** The connection is gone or new, or another scene is there: whatever was going on with the server is over. */
  interrupted: () => void;
  /** Something that all viewers should know. */
  told: (message: string) => void;
}

interface Waiting {
  command: Command;
  answer?: (answer: Answer | null) => void;
}

const isLoopback = (host: string): boolean => host === "localhost" || host === "[::1]" || /^127(\.\d+){3}$/.test(host);

export class Connection {
  /** Nobody sees the page, and it draws nothing. */
  hidden = false;
  private nextId = 1;
  private remote = false; // the server is on another machine
  private readonly unanswered = new Map<number, Waiting>();

  constructor(
    private readonly port: Port,
    private readonly store: Store,
    private readonly events: ConnectionEvents,
  ) {
    port.onmessage = ({ data }) => this.receive(data);
  }

  connect(url?: string): void {
    if (url !== undefined) this.remote = !isLoopback(new URL(url).hostname);
    this.port.postMessage(url === undefined ? { kind: "connect" } : { kind: "connect", url });
  }

  /** Without a connection nothing is sent and the user is told. Nor before the hello: what was known may not be so any more. */
  send(command: Command, answer?: (answer: Answer | null) => void): void {
    const state = this.store.get();
    if (!isOpen(state)) {
      const connected = state.link.status === "open";
      this.events.refused(command, connected ? "the server is not ready yet" : "there is no connection to the server");
      answer?.(null);
      return;
    }
    const id = this.nextId++;
    this.unanswered.set(id, answer ? { command, answer } : { command });
    this.port.postMessage({ kind: "command", id, command });
  }

  /** The answer; null when the command was refused (of which the user is told) or the connection ended. */
  request(command: Command): Promise<Answer | null> {
    return new Promise((resolve) => this.send(command, resolve));
  }

  /** This frame and all before it are on the screen. */
  drawn(sequence: number): void {
    this.port.postMessage({ kind: "drawn", sequence });
  }

  private receive(event: LinkEvent): void {
    if (event.kind === "link") {
      this.forgetCommands();
      // Until the new hello, nothing is known about the other side; the old hello stays as long as its picture does.
      const unknown = { simulation: null, progress: null, settings: null, recording: null, linkReport: null };
      this.store.set({ link: event.link, stale: this.store.get().hello !== null, ...unknown });
      this.events.interrupted();
    } else if (event.kind === "binary") {
      if (event.dropped) this.store.set({ framesDropped: this.store.get().framesDropped + event.dropped });
      this.events.binary(event.message);
      if (event.message.kind === "frame") this.port.postMessage({ kind: "ready" });
    } else {
      this.receiveText(event.message);
    }
  }

  private forgetCommands(): void {
    const waiting = [...this.unanswered.values()];
    this.unanswered.clear();
    for (const { answer } of waiting) answer?.(null);
  }

  private receiveText(message: TextMessage): void {
    switch (message.type) {
      case "hello":
        this.welcome(message);
        break;
      case "state":
        this.store.set({ simulation: message });
        break;
      case "settings":
        this.store.set({ settings: message });
        break;
      case "recording":
        this.store.set({ recording: message });
        break;
      case "link":
        // What was not sent to a page that draws nothing says nothing about the network.
        this.store.set({ linkReport: this.hidden ? null : message });
        break;
      case "log":
        this.events.told(message.message);
        break;
      case "progress":
        this.store.set({ progress: message.fraction < 1 ? message : null });
        break;
      case "ok": {
        const waiting = this.unanswered.get(message.id);
        this.unanswered.delete(message.id);
        waiting?.answer?.(message);
        break;
      }
      case "error":
        this.refuse(message);
    }
  }

  private welcome(hello: Hello): void {
    const { hello: last } = this.store.get();
    const other = last?.scene.name !== hello.scene.name;
    if (last && other) this.events.interrupted();
    const { colouring, wireframe, cut } = viewOf(hello);
    this.store.set({
      hello,
      stale: false,
      simulation: null,
      progress: null,
      settings: null,
      selectedForce: null,
      scrub: null,
      // What the user chose for this scene survives a reconnection.
      ...(other ? { colouring, wireframe, cut, tool: null } : {}),
    });
    // On one machine bytes are cheaper than the time to unpack them.
    if (this.remote && hello.capabilities?.includes("compress")) this.send({ command: "compression", value: true });
  }

  private refuse(error: Refusal): void {
    const waiting = error.id === null ? undefined : this.unanswered.get(error.id);
    if (error.id !== null) this.unanswered.delete(error.id);
    // "/barycentric/2" and "is 7; use 0..1" read together as a sentence.
    const where = (error.pointer ?? "").split("/").filter(Boolean).join(" ");
    this.events.refused(waiting?.command ?? null, `${where} ${error.message}`.trim());
    waiting?.answer?.(null);
  }
}
