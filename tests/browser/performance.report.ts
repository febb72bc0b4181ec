// What a frame of a large surface costs the page's main thread, by a scripted stream of frames. Writes
// tests/reports/browser.md; run by `npm --prefix web run report:browser` on an idle machine.
//
// Drawing is left away: Chromium draws by software here, a graphics processor does it on its own. Uploads are what
// WebGL's bufferSubData and bufferData take; decoding happens in the worker and is measured beside it, in the same V8.

import { execSync } from "node:child_process";
import { writeFileSync } from "node:fs";
import { cpus } from "node:os";
import { expect, it } from "vitest";

import { decodeBinary } from "../../web/src/protocol";
import { startMockServer } from "./mock_server.mjs";
import { encodeFrame } from "./mock_wire.mjs";
import { FLAGS, launch, shown } from "./support";

const FRAMES = 300;
const DISTINCT = 30;
const LIMIT = 6; // [ms]

interface Upload {
  uploads: number[][]; // [ms] of each call, by redraw
}

it("writes the report", async () => {
  const rows: string[] = [];
  for (const detail of [5, 6, 7]) rows.push(await measure(detail));
  const page = `# The browser's main thread

Made by \`npm --prefix web run report:browser\` on ${new Date().toISOString().slice(0, 10)}, ${cpus()[0].model}, ${cpus().length} threads, ${chromium()}. Do not
edit: run the command again.

${FRAMES} frames at 30 a second, with a new normal for each vertex and new positions each time. Milliseconds a redraw, median (95 of 100 are
below the number in brackets). Decoding happens in a worker; it is added here all the same. Wanted: at most ${LIMIT} ms in all for 50,000
vertices. Drawing is not counted, as Chromium draws by software on the machine of this report.

| vertices | decode | mix, unpack, normals | upload | sum of medians | |
|---|---|---|---|---|---|
${rows.join("\n")}
`;
  writeFileSync(new URL("../reports/browser.md", import.meta.url), page);
  expect(rows.length).toBe(3);
}, 600_000);

async function measure(detail: number): Promise<string> {
  const browser = await launch();
  const server = await startMockServer({ detail, playing: false });
  const { simulation } = server;
  const vertices = simulation.shape.rest.length / 3;
  const stream = Array.from({ length: DISTINCT }, (_, i) => {
    simulation.time = i / 30;
    return encodeFrame(simulation) as Buffer;
  });
  const page = await browser.newPage({ viewport: { width: 640, height: 360 } });
  await page.addInitScript(() => {
    const record: Upload = { uploads: [] };
    Object.assign(window, { record });
    const prototype = WebGL2RenderingContext.prototype;
    for (const name of ["bufferSubData", "bufferData"] as const) {
      const original = prototype[name] as (...args: unknown[]) => void;
      Object.assign(prototype, {
        [name](this: WebGL2RenderingContext, ...args: unknown[]) {
          const start = performance.now();
          original.apply(this, args);
          record.uploads.at(-1)?.push(performance.now() - start);
        },
      });
    }
    const turn = () => {
      record.uploads.push([]);
      requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
  });
  await page.goto(`${server.url}?quality=low`);
  await shown(page);
  for (let i = 0; i < FRAMES; ++i) {
    const frame = Buffer.from(stream[i % DISTINCT]);
    frame.writeUInt32LE(1000 + i, 8);
    frame.writeDoubleLE(1 + i / 30, 16);
    for (const { socket } of simulation.viewers) socket.send(frame);
    await new Promise((resolve) => setTimeout(resolve, 1000 / 30));
  }
  const costs = await page.evaluate(() => window.tetfront!.costs());
  const uploads = (await page.evaluate(() => (window as unknown as { record: Upload }).record.uploads))
    .map((calls) => calls.reduce((a, b) => a + b, 0))
    .filter((sum) => sum > 0)
    .slice(5);
  await browser.close();
  await server.close();
  if (costs.length <= 20) throw new Error(`only ${costs.length} redraws: the machine is too busy to measure`);

  const decodes = stream.concat(stream, stream).map((bytes) => {
    const copy = new Uint8Array(bytes).buffer;
    const start = performance.now();
    decodeBinary(copy);
    return performance.now() - start;
  });
  const all = [decodes, costs, uploads];
  const sum = all.reduce((total, list) => total + quantile(list, 0.5), 0);
  const verdict = vertices < 50_000 ? "" : sum <= LIMIT ? "reached" : "missed";
  const cells = all.map((list) => `${quantile(list, 0.5).toFixed(2)} (${quantile(list, 0.95).toFixed(2)})`);
  return `| ${vertices.toLocaleString("en")} | ${cells.join(" | ")} | ${sum.toFixed(2)} | ${verdict} |`;
}

function quantile(values: number[], q: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))];
}

const chromium = (): string =>
  execSync(`${process.env["CHROMIUM"] ?? "/usr/bin/chromium"} --version ${FLAGS[0]}`)
    .toString()
    .trim();
