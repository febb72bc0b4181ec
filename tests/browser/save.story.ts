// Someone downloads the pictures of a recording: more than fit into memory, so they go to the disk as they come. Meanwhile the
// sheet may be closed; a refusal is told in words. Once as Chromium writes the file itself, once as other browsers do, by a link.

import { readFileSync } from "node:fs";
import type { Browser, Page } from "playwright-core";
import { afterAll, afterEach, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { launch, memoryOf, open, screenshot } from "./support";

const SIZE = 24e6;
const HALF = 16e6;

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3, archive: SIZE, playing: false });
  server.simulation.recordings = [{ name: "mock-20260131-235959.tfr", bytes: 1e6 }];
  ({ page, problems } = await open(browser, server.url, { width: 1000 }));
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const goOn = () => {
  server.archive.hold = Infinity;
  server.archive.held.emit("go");
};
afterEach(goOn);

/** A dialog that picks files of the browser's own for this page, which one can read again; `null`: a browser without one. */
const pick = (what: "file" | "nothing" | null) =>
  page.evaluate((choice) => {
    window.showSaveFilePicker =
      choice === null
        ? undefined
        : async ({ suggestedName }) => {
            if (choice === "nothing") throw new DOMException("The user aborted a request.", "AbortError");
            return (await navigator.storage.getDirectory()).getFileHandle(suggestedName, { create: true });
          };
  }, what);

/** Null: there is no such file. Else its size, and whether it is what the server sends. */
const kept = (name: string) =>
  page.evaluate(async (file) => {
    const folder = await navigator.storage.getDirectory();
    const handle = await folder.getFileHandle(file).catch(() => null);
    if (!handle) return null;
    const bytes = new Uint8Array(await (await handle.getFile()).arrayBuffer());
    await folder.removeEntry(file);
    return { size: bytes.length, whole: bytes.every((x, i) => x === ((i >> 16) & 255)) };
  }, name);

const sheet = async () => {
  if (!(await page.isVisible("#panel"))) await page.click("[aria-controls=panel]");
  await page.click("text=Recordings …");
  await page.waitForSelector(".files button");
};
const button = () => page.locator(".files button", { hasText: /Pictures|Cancel/ });
const label = (text: RegExp) =>
  page.waitForFunction(
    (pattern) => new RegExp(pattern).test(document.querySelector(".files button")!.textContent!),
    text.source,
  );

describe("where the page may write files", () => {
  it("goes to the disk piece by piece, and goes on while the sheet is closed", async () => {
    await pick("file");
    await sheet();
    const before = await memoryOf(page);
    server.archive.hold = HALF;
    await button().click();
    await label(/^Cancel · 1[56](\.\d)? MB$/);
    const during = await memoryOf(page);
    expect(during.heap + during.buffers - before.heap - before.buffers).toBeLessThan(6e6);
    await page.keyboard.press("Escape");
    await sheet();
    expect(await button().innerText()).toMatch(/^Cancel · 1/);
    await screenshot(page, "saving");
    goOn();
    await label(/^Pictures$/);
    expect(await kept("mock-20260131-235959.zip")).toEqual({ size: SIZE, whole: true });
    expect(server.archive.broken).toBe(0);
  });

  it("is cancelled after the sheet was closed and opened again, and leaves no file", async () => {
    server.archive.hold = HALF;
    await button().click();
    await label(/^Cancel · 1[56]/);
    await page.keyboard.press("Escape");
    await sheet();
    await button().click();
    await label(/^Pictures$/);
    expect(await kept("mock-20260131-235959.zip")).toBeNull();
    await expect.poll(() => server.archive.broken).toBe(1);
    expect(await page.innerText(".problem")).toBe("");
  });

  it("does nothing when no file is picked", async () => {
    await pick("nothing");
    server.archive.sent = -1;
    await button().click();
    await page.waitForTimeout(300);
    await label(/^Pictures$/);
    expect(server.archive.sent).toBe(-1);
    expect(await page.innerText(".problem")).toBe("");
  });

  it("says why a file was refused, and leaves none", async () => {
    await pick("file");
    await page.click(".files >> text=Video");
    await page.waitForSelector("text=Video: there is no ffmpeg here; install it");
    expect(await kept("mock-20260131-235959.mp4")).toBeNull();
    expect(problems.splice(0)).toEqual([expect.stringContaining("422")]); // the browser's own words
  });
});

describe("where it may not", () => {
  it("comes by a link, which the browser downloads", async () => {
    await pick(null);
    const [download] = await Promise.all([page.waitForEvent("download"), button().click()]);
    const bytes = readFileSync(await download.path());
    expect(bytes.length).toBe(SIZE);
    expect(bytes.every((x, i) => x === ((i >> 16) & 255))).toBe(true);
  });

  it("says why a file was refused, in a toast when the sheet is closed", async () => {
    let answer = () => {};
    const closed = new Promise<void>((resolve) => (answer = resolve));
    await page.route("**/video.mp4*", async (route) => {
      await closed;
      await route.continue();
    });
    await page.click(".files >> text=Video");
    await page.keyboard.press("Escape");
    answer();
    await page.waitForSelector(".toast >> text=Video: there is no ffmpeg here; install it");
    expect(problems.splice(0)).toEqual([expect.stringContaining("422")]);
  });
});
