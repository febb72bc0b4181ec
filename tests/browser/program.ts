// The real program for stories: `tetfront serve` with a small scene of its own.
// TETFRONT_BINARY: the program (default build/dev/server/tetfront).
//
//     const server = await Program.serve(writeScene());      server.url;      await server.stop();

import { spawn } from "node:child_process";
import type { ChildProcess } from "node:child_process";
import { once } from "node:events";
import { existsSync, mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { createInterface } from "node:readline";

const root = new URL("../../", import.meta.url).pathname;
const program = resolve(root, process.env["TETFRONT_BINARY"] ?? "build/dev/server/tetfront");

// A bar that stands on the ground: soft above, stiff below, some hundred vertices.
const bar = {
  schema_version: 1,
  title: "A soft bar",
  up: "z",
  mesh: { box: { low: [0, 0, 0], high: [0.3, 0.3, 0.9], cells: [2, 2, 6] } },
  levels: 2,
  material: {
    density: 1000,
    poisson: 0.3,
    young: { exponential: { axis: "z", values: [2e6, 1e5] } },
  },
  pins: [{ half_space: { point: [0, 0, 0.001], normal: [0, 0, 1] } }],
  gravity: [2, 0, -9.81],
  damping: { mass: 1 },
};

/** The bar's file, in a folder of its own. */
export function writeScene(): string {
  const file = join(mkdtempSync(join(tmpdir(), "tetfront-")), "bar.json");
  writeFileSync(file, JSON.stringify(bar));
  return file;
}

export class Program {
  private constructor(
    private readonly child: ChildProcess,
    readonly url: string,
  ) {}

  /** port 0: any free one. What the server keeps lies beside the scene. */
  static async serve(file: string, port = 0): Promise<Program> {
    if (!existsSync(program)) throw new Error(`there is no ${program}: build it, or set TETFRONT_BINARY`);
    const child = spawn(program, [
      "serve",
      file,
      "--port",
      String(port),
      "--web",
      join(root, "web/dist"),
      "--data",
      dirname(file),
    ]);
    let errors = "";
    child.stderr.on("data", (data: Buffer) => (errors += data.toString()));
    const failed = once(child, "exit").then(([code]) => {
      throw new Error(`tetfront ended with ${code}: ${errors}`);
    });
    failed.catch(() => undefined); // ends later, on purpose
    const line = once(createInterface(child.stdout), "line").then(([text]: string[]) => text.trim());
    return new Program(child, await Promise.race([line, failed]));
  }

  get port(): number {
    return Number(new URL(this.url).port);
  }

  /** Returns the exit status. */
  async stop(signal: NodeJS.Signals = "SIGTERM"): Promise<number | null> {
    const exit = once(this.child, "exit");
    this.child.kill(signal);
    return ((await exit) as [number | null])[0];
  }
}
