// Changes parts of other stiffness. What has just been said counts before the server has told everybody: two quick presses of a
// key are two steps.
//
//     edits.step(part, 1, 1);    edits.set(part, 5);      edits.clear();

import type { Command, StiffnessPart } from "./messages";
import { clearParts, foresee, setPart, stepPart } from "./parts";
import type { Place } from "./parts";
import type { Store } from "./store";

const PATIENCE = 1000; // [ms] after which the server's word alone counts

export class PartEdits {
  private said: { command: Command; at: number /* ms */ }[] = [];

  constructor(
    private readonly store: Store,
    private readonly send: (command: Command) => void,
    private readonly now: () => number = () => performance.now(),
  ) {}

  /** As they will be; to say again what has been done already changes nothing. */
  get parts(): readonly StiffnessPart[] {
    const recent = this.now() - PATIENCE;
    this.said = this.said.filter(({ at }) => at > recent);
    return foresee(
      this.store.get().settings?.stiffness_parts ?? [],
      this.said.map(({ command }) => command),
    );
  }

  step(part: StiffnessPart, below: number, direction: 1 | -1): void {
    this.say(stepPart(this.parts, part, below, direction));
  }

  set(part: Place, value: number): void {
    this.say(setPart(this.parts, part, value));
  }

  clear(): void {
    this.say(clearParts(this.parts));
  }

  /** The server has refused something. */
  forget(): void {
    this.said = [];
  }

  private say(commands: readonly Command[]): void {
    const at = this.now();
    for (const command of commands) {
      this.said.push({ command, at });
      this.send(command);
    }
  }
}
