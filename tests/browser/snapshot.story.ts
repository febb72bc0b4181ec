// Pictures to keep, by the real program: the server's picture is what the page shows, and a recording comes as pictures that
// open.

import { readFileSync } from "node:fs";
import type { Browser, Page } from "playwright-core";
import { PNG } from "pngjs";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { Program, writeScene } from "./program";
import { keep, launch, open, pause, state, still } from "./support";
import { unzip } from "./unzip";

let browser: Browser;
let server: Program;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await Program.serve(writeScene());
  ({ page, problems } = await open(browser, server.url, { quality: "full" }));
});
afterAll(async () => {
  await browser?.close();
  await server?.stop("SIGKILL");
});

/** The server's picture without its legend, and the same part of the canvas. */
async function bothPictures(): Promise<{ server: PNG; canvas: PNG }> {
  const asked = page.waitForRequest((request) => request.url().includes("snapshot.png"));
  const [kept] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("s")]);
  const whole = PNG.sync.read(readFileSync(await kept.path()));
  const address = new URL((await asked).url());
  const view = JSON.parse(address.searchParams.get("view")!) as object;
  address.searchParams.set("view", JSON.stringify({ ...view, legend: false }));
  let answer = await fetch(address);
  while (answer.status === 429) answer = await fetch(address); // ten pictures a second at most
  const bare = PNG.sync.read(Buffer.from(await answer.arrayBuffer()));
  expect([bare.width, bare.height]).toEqual([whole.width, whole.height]);

  const [download] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("Shift+S")]);
  const all = PNG.sync.read(readFileSync(await download.path()));
  expect([all.width, all.height]).toEqual([640, 360]);
  const canvas = new PNG({ width: bare.width, height: bare.height });
  PNG.bitblt(all, canvas, 0, 58, bare.width, bare.height, 0, 0); // below the bar at the top: src/page.ts
  keep("snapshot_server", bare);
  keep("snapshot_canvas", canvas);
  return { server: bare, canvas };
}

/** Where a picture shows the object: colours, before a background of greys, which is transparent on the canvas. */
const isObject = ({ data }: PNG, i: number): boolean => {
  const [r, g, b, opacity] = data.subarray(4 * i, 4 * i + 4);
  return opacity > 200 && Math.max(r, g, b) - Math.min(r, g, b) > 25;
};

/** Share of the object's pixels that both have, and by how much these differ, channel by channel, in the mean [0..255]. */
function compare(a: PNG, b: PNG) {
  let [both, either, difference] = [0, 0, 0];
  for (let i = 0; i < a.width * a.height; ++i) {
    const [inA, inB] = [isObject(a, i), isObject(b, i)];
    if (inA || inB) ++either;
    if (!inA || !inB) continue;
    ++both;
    for (const c of [0, 1, 2]) difference += Math.abs(a.data[4 * i + c] - b.data[4 * i + c]) / 3;
  }
  return { pixels: both, overlap: both / either, difference: difference / both };
}

describe("the server's picture", () => {
  it.each([
    ["levels", []],
    ["stiffness", ["c"]],
    ["a turned camera", ["Shift+ArrowLeft", "Shift+ArrowLeft", "PageUp"]],
  ])("is what the canvas shows: %s", async (_, keys) => {
    await pause(page);
    for (const key of keys) await page.keyboard.press(key);
    await still(page);
    const { server: drawn, canvas } = await bothPictures();
    const same = compare(drawn, canvas);
    expect(same.pixels).toBeGreaterThan(1000);
    expect(same.overlap).toBeGreaterThan(0.95); // the outline
    expect(same.difference).toBeLessThan(20); // lights and shadows are not the same
    // The measure sees what is wrong: a mirrored picture.
    const mirrored = new PNG({ width: drawn.width, height: drawn.height });
    for (let y = 0; y < drawn.height; ++y)
      for (let x = 0; x < drawn.width; ++x) PNG.bitblt(drawn, mirrored, x, y, 1, 1, drawn.width - 1 - x, y);
    expect(compare(mirrored, canvas).overlap).toBeLessThan(0.95);
  });
});

describe("a recording", () => {
  it("comes as a zip file of pictures that open", async () => {
    if (!(await state(page)).simulation?.playing) await page.keyboard.press("Space");
    await page.keyboard.press("v");
    await page.waitForFunction(() => (window.tetfront!.state().recording?.frames ?? 0) > 5);
    await page.keyboard.press("v");
    await page.waitForFunction(() => window.tetfront!.state().recording?.active === false);
    const { frames, name } = (await state(page)).recording!;
    await page.click("[aria-controls=panel]");
    await page.click("text=Recordings …");
    await page.evaluate(() => (window.showSaveFilePicker = undefined)); // save.story.ts has the other way
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(".files >> text=Pictures")]);
    expect(download.suggestedFilename()).toBe(name.replace(/tfr$/, "zip"));
    const files = unzip(readFileSync(await download.path()));
    expect(files.map(({ name: file }) => file)).toEqual(
      Array.from({ length: frames }, (_, i) => `${String(i).padStart(6, "0")}.png`),
    );
    const pictures = files.map(({ bytes }) => PNG.sync.read(bytes));
    for (const { width, height } of pictures) expect([width, height]).toEqual([640, 236]);
    expect(pictures[0].data.equals(pictures.at(-1)!.data)).toBe(false);
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
