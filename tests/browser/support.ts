// What every story needs: a Chromium, a page that fails the story on any console error, and pixels to look at.

import { execFileSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { chromium } from "playwright-core";
import type { Browser, Page } from "playwright-core";
import { PNG } from "pngjs";
import { expect } from "vitest";

import type { Frame } from "../../web/src/protocol";
import type { State } from "../../web/src/store";

declare global {
  interface Window {
    /** What the page shows (web/src/main.ts). */
    tetfront?: {
      state(): State;
      positions(): Float32Array | null;
      frame(): Frame | null;
      redraws(): number;
      census(): { geometries: number; textures: number; programs: number; tets: number };
      costs(): number[];
      moments(): number;
      times(): number[];
    };
  }
}

export const FLAGS = [
  ...["--no-sandbox", "--enable-unsafe-swiftshader", "--disable-background-networking", "--disable-component-update"],
  ...["--disable-sync", "--no-first-run", "--disable-quic"],
];

const CHROMIUM = process.env["CHROMIUM"] ?? "/usr/bin/chromium";

export const launch = (): Promise<Browser> => chromium.launch({ executablePath: CHROMIUM, args: FLAGS });

export const chromiumVersion = (): string =>
  execFileSync(CHROMIUM, ["--version", FLAGS[0]], { stdio: ["ignore", "pipe", "ignore"] })
    .toString()
    .trim();

/** Where screenshots of a run are left to be looked at. */
const RESULTS = new URL("../../test-results/", import.meta.url).pathname;

export interface OpenOptions {
  width?: number;
  height?: number;
  dark?: boolean;
  quality?: "low" | "full"; // the software rasteriser takes several times as long for the full one
  fragment?: string; // of the address: web/src/share.ts
}

/** Opens the page and waits for its first frame. `problems` collects console errors, which no story expects unless it says so. */
export async function open(
  browser: Browser,
  url: string,
  { width = 640, height = 360, dark = false, quality = "low", fragment = "" }: OpenOptions = {},
) {
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: dark ? "dark" : "light" });
  const problems: string[] = [];
  page.on("console", (message) => {
    if (message.type() === "error") problems.push(message.text());
  });
  page.on("pageerror", (error) => problems.push(error.message));
  page.on("request", (request) => {
    if (!request.url().startsWith(url)) problems.push(`asked for ${request.url()}`);
  });
  await page.goto(`${url}?quality=${quality}${fragment ? `#${fragment}` : ""}`);
  await shown(page);
  return { page, problems };
}

/** Until a frame is on the screen. */
export async function shown(page: Page): Promise<void> {
  await page.waitForFunction(() => window.tetfront?.frame() && window.tetfront.positions()?.some((x) => x !== 0));
}

export const state = (page: Page): Promise<State> => page.evaluate(() => window.tetfront!.state());

/** Surface positions now, [S][3]. */
export const positions = (page: Page): Promise<number[]> =>
  page.evaluate(() => Array.from(window.tetfront!.positions() ?? []));

/** The longest way that a vertex has come. */
export function largestMove(before: number[], after: number[]): number {
  expect(after.length).toBe(before.length);
  let largest = 0;
  for (let i = 0; i < before.length; i += 3)
    largest = Math.max(largest, Math.hypot(...[0, 1, 2].map((k) => after[i + k] - before[i + k])));
  return largest;
}

/** Pauses, and waits until no frame comes any more. */
export async function pause(page: Page): Promise<void> {
  if ((await state(page)).simulation?.playing !== false) await page.keyboard.press("Space");
  await page.waitForFunction(() => window.tetfront!.state().simulation?.playing === false);
  await still(page);
}

/** Until the picture has stayed the same for ten turns of the browser's drawing loop, however slow they are. */
export const still = (page: Page): Promise<void> =>
  page.evaluate(
    () =>
      new Promise<void>((resolve) => {
        let last = -1;
        let quiet = 0;
        const turn = () => {
          const redraws = window.tetfront!.redraws();
          quiet = redraws === last ? quiet + 1 : 0;
          last = redraws;
          if (quiet < 10) requestAnimationFrame(turn);
          else resolve();
        };
        turn();
      }),
  );

/** Screen position [px] of a surface point, found by looking for the grab cursor around the middle of the picture. */
export async function pointOnObject(page: Page): Promise<{ x: number; y: number }> {
  const { width, height } = page.viewportSize()!;
  for (const fraction of [0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65])
    for (const sideways of [0.5, 0.46, 0.54, 0.42, 0.58]) {
      const at = { x: Math.round(sideways * width), y: Math.round(fraction * height) };
      await page.mouse.move(at.x, at.y);
      await page.waitForTimeout(150);
      if (await page.evaluate(() => document.getElementById("view")!.classList.contains("over-object"))) return at;
    }
  throw new Error("the object is not under the middle of the picture");
}

export interface Pixels {
  data: Uint8Array; // RGBA
  colours: number; // different ones
  spread: number; // standard deviation of the brightness, 0..255
}

/** The middle of the picture, free of panels. */
export async function middle(page: Page, name?: string): Promise<Pixels> {
  const { width, height } = page.viewportSize()!;
  const clip = { x: 0.3 * width, y: 0.2 * height, width: 0.4 * width, height: 0.55 * height };
  const { data } = PNG.sync.read(await page.screenshot({ clip }));
  if (name) await screenshot(page, name);
  const colours = new Set<number>();
  let sum = 0;
  let squares = 0;
  for (let i = 0; i < data.length; i += 4) {
    colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    const brightness = (data[i] + data[i + 1] + data[i + 2]) / 3;
    sum += brightness;
    squares += brightness ** 2;
  }
  const n = data.length / 4;
  return { data, colours: colours.size, spread: Math.sqrt(Math.max(0, squares / n - (sum / n) ** 2)) };
}

/** Share of pixels that differ by more than a shade. */
export function difference(a: Pixels, b: Pixels): number {
  let different = 0;
  for (let i = 0; i < a.data.length; i += 4)
    if ([0, 1, 2].some((c) => Math.abs(a.data[i + c] - b.data[i + c]) > 8)) ++different;
  return different / (a.data.length / 4);
}

/** The page's heap and the buffers outside of it [bytes] after a garbage collection, and what three.js counts of the graphics processor's memory. */
export async function memoryOf(page: Page) {
  const session = await page.context().newCDPSession(page);
  await session.send("HeapProfiler.collectGarbage");
  const { usedSize, ...more } = await session.send("Runtime.getHeapUsage");
  await session.detach();
  const { backingStorageSize: buffers } = more as { backingStorageSize: number }; // newer than the types
  return { heap: usedSize, buffers, gpu: await page.evaluate(() => window.tetfront!.census()) };
}

/** Leaves a picture beside the screenshots. */
export function keep(name: string, picture: PNG): void {
  mkdirSync(RESULTS, { recursive: true });
  writeFileSync(`${RESULTS}${name}.png`, PNG.sync.write(picture));
}

export async function screenshot(page: Page, name: string): Promise<void> {
  mkdirSync(RESULTS, { recursive: true });
  await page.screenshot({ path: `${RESULTS}${name}.png` });
}
