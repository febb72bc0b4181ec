// The page's end of the worker: puts what the server says into the store, hands binary data to the viewer, numbers the
// commands and matches the answers.

import type { LinkEvent } from "./link";
import type { BinaryMessage, Command, Refusal } from "./protocol";
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
  /** The connection is gone or new: whatever was going on with the server is over. */
  interrupted: () => void;
}

export class Connection {
  private nextId = 1;
  private readonly unanswered = new Map<number, Command>();

  constructor(
    private readonly port: Port,
    private readonly store: Store,
    private readonly events: ConnectionEvents,
  ) {
    port.onmessage = ({ data }) => this.receive(data);
  }

  connect(url?: string): void {
    this.port.postMessage(url === undefined ? { kind: "connect" } : { kind: "connect", url });
  }

  /** Without a connection nothing is sent and the user is told. */
  send(command: Command): void {
    if (this.store.get().link.status !== "open") {
      this.events.refused(command, "there is no connection to the server");
      return;
    }
    const id = this.nextId++;
    this.unanswered.set(id, command);
    this.port.postMessage({ kind: "command", id, command });
  }

  private receive(event: LinkEvent): void {
    if (event.kind === "link") {
      this.unanswered.clear();
      this.events.interrupted();
      // Until the new hello, nothing is known about the other side; the old hello stays as long as its picture does.
      this.store.set(
        event.link.status === "open" ? { link: event.link } : { link: event.link, simulation: null, progress: null },
      );
    } else if (event.kind === "binary") {
      if (event.dropped) this.store.set({ framesDropped: this.store.get().framesDropped + event.dropped });
      this.events.binary(event.message);
      if (event.message.kind === "frame") this.port.postMessage({ kind: "ready" });
    } else {
      this.receiveText(event.message);
    }
  }

  private receiveText(message: (LinkEvent & { kind: "text" })["message"]): void {
    switch (message.type) {
      case "hello": {
        const first = this.store.get().hello?.scene.name !== message.scene.name;
        this.store.set({
          hello: message,
          simulation: null,
          progress: null,
          // What the user chose for this scene survives a reconnection.
          ...(first ? { colouring: message.view.colouring, wireframe: message.view.wireframe } : {}),
        });
        break;
      }
      case "state":
        this.store.set({ simulation: message });
        break;
      case "progress":
        this.store.set({ progress: message.fraction < 1 ? message : null });
        break;
      case "ok":
        this.unanswered.delete(message.id);
        break;
      case "error":
        this.refuse(message);
    }
  }

  private refuse(error: Refusal): void {
    const command = error.id === null ? null : (this.unanswered.get(error.id) ?? null);
    if (error.id !== null) this.unanswered.delete(error.id);
    // "/barycentric/2" and "is 7; use 0..1" read together as a sentence.
    const where = (error.pointer ?? "").split("/").filter(Boolean).join(" ");
    this.events.refused(command, `${where} ${error.message}`.trim());
  }
}
