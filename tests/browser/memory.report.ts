// Whether a page that stays open keeps its memory: ten minutes of frames with fifty changes of the scene, while colourings,
// shapes and cuts change and somebody pulls. Writes tests/reports/browser_memory.md; run by
// `npm --prefix web run report:browser`. library.story.ts has the same in short.

import { writeFileSync } from "node:fs";
import { cpus } from "node:os";
import type { Page } from "playwright-core";
import { expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { chromiumVersion, launch, memoryOf, open } from "./support";

const MINUTES = Number(process.env["TETFRONT_MINUTES"] ?? 10);
const CHANGES = Number(process.env["TETFRONT_CHANGES"] ?? 50);
const LIMIT = 1.15; // heap after over heap before

it(
  "writes the report",
  async () => {
    const browser = await launch();
    const server = await startMockServer({ detail: 3 });
    const { page, problems } = await open(browser, server.url, { width: 400, height: 300 });
    const load = (name: string) => {
      server.simulation.load({ name, title: name, detail: 3 });
      return page.waitForFunction(
        (n) => window.tetfront!.state().hello?.scene.name === n && window.tetfront!.frame(),
        name,
      );
    };
    // The page keeps the last 20 seconds to look back at: it is full before the first sample.
    for (let i = 0; i < 5; ++i) await use(page, () => load(`warm ${i}`), i, 6000);
    const samples: { minute: number; memory: Awaited<ReturnType<typeof memoryOf>> }[] = [];
    const start = Date.now();
    const sample = async () => samples.push({ minute: (Date.now() - start) / 60_000, memory: await memoryOf(page) });
    await sample();
    for (let i = 0; i < CHANGES; ++i) {
      const until = start + ((i + 1) / CHANGES) * MINUTES * 60_000;
      await use(page, () => load(`scene ${i}`), i, until - Date.now());
      if ((i + 1) % 5 === 0) await sample();
    }
    const frames = server.simulation.sequence;
    await browser.close();
    await server.close();
    expect(problems).toEqual([]);

    const [first, last] = [samples[0], samples.at(-1)!].map(({ memory }) => memory);
    const flat = last.heap / first.heap < LIMIT && JSON.stringify(last.gpu) === JSON.stringify(first.gpu);
    const rows = samples.map(
      ({ minute, memory: { heap, gpu } }) =>
        `| ${minute.toFixed(1)} | ${(heap / 1e6).toFixed(2)} | ${gpu.geometries} | ${gpu.textures} | ${gpu.programs} |`,
    );
    const text = `# The page's memory

Made by \`npm --prefix web run report:browser\` on ${new Date().toISOString().slice(0, 10)}, ${cpus()[0].model}, ${cpus().length} threads, ${chromiumVersion()}. Do not
edit: run the command again.

${MINUTES} minutes, ${frames.toLocaleString("en")} frames, ${CHANGES} changes of the scene; between them colourings, tets, cuts and pulls. The heap after a
garbage collection, and what three.js counts of the graphics processor's memory. Wanted: a heap at the end of at most ${LIMIT} times the heap at
the beginning, and the same buffers. It is ${(last.heap / first.heap).toFixed(3)} times: ${flat ? "reached" : "missed"}.

| minute | heap [MB] | geometries | textures | programs |
|---|---|---|---|---|
${rows.join("\n")}
`;
    writeFileSync(new URL("../reports/browser_memory.md", import.meta.url), text);
    expect(samples.length).toBe(1 + Math.floor(CHANGES / 5));
  },
  (3 * MINUTES + 5) * 60_000,
);

/** One change of the scene and what a user does afterwards, for this long [ms]; at its end every time the same is shown. */
async function use(page: Page, change: () => Promise<unknown>, turn: number, duration: number): Promise<void> {
  const end = Date.now() + duration;
  await change();
  // Each for a while; the software rasteriser takes long for tets, so nothing else happens meanwhile.
  const toggle = ["e", "x", "w"][turn % 3];
  await page.keyboard.press("c");
  await page.keyboard.press(toggle);
  await page.waitForTimeout(Math.max(0, 0.3 * (end - Date.now())));
  await page.keyboard.press(toggle);
  const { width, height } = page.viewportSize()!;
  await page.mouse.move(width / 2, height / 2);
  await page.mouse.down();
  await page.mouse.move(width / 2 + 30, height / 2 - 10);
  await page.waitForTimeout(Math.max(0, 0.6 * (end - Date.now())));
  await page.mouse.up();
  await page.waitForTimeout(Math.max(0, end - Date.now()));
}
