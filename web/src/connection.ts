// The page's end of the worker: puts what the server says into the store, hands binary data to the viewer, numbers the
// commands and matches the answers.

import type { LinkEvent } from "./link";
import type { Answer, Command, Hello, Refusal, TextMessage } from "./messages";
import type { BinaryMessage } from "./protocol";
import type { State, Store } from "./store";
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

  /** Without a connection nothing is sent and the user is told. */
  send(command: Command, answer?: (answer: Answer | null) => void): void {
    if (this.store.get().link.status !== "open") {
      this.events.refused(command, "there is no connection to the server");
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

  private receive(event: LinkEvent): void {
    if (event.kind === "link") {
      this.forgetCommands();
      this.events.interrupted();
      // Until the new hello, nothing is known about the other side; the old hello stays as long as its picture does.
      const unknown: Partial<State> = { simulation: null, progress: null, settings: null, recording: null };
      this.store.set({ link: event.link, linkReport: null, ...(event.link.status === "open" ? {} : unknown) });
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
        this.store.set({ settings: message, initialSettings: this.store.get().initialSettings ?? message });
        break;
      case "recording":
        this.store.set({ recording: message });
        break;
      case "link":
        this.store.set({ linkReport: message });
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
    // On one machine bytes are cheaper than the time to unpack them.
    if (this.remote && hello.capabilities?.includes("compress")) this.send({ command: "compression", value: true });
    const { hello: last } = this.store.get();
    const other = last?.scene.name !== hello.scene.name;
    if (last && other) this.events.interrupted();
    this.store.set({
      hello,
      simulation: null,
      progress: null,
      settings: null,
      initialSettings: null,
      selectedForce: null,
      scrub: null,
      // What the user chose for this scene survives a reconnection.
      ...(other ? { colouring: hello.view.colouring, wireframe: hello.view.wireframe, cut: null, tool: null } : {}),
    });
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
