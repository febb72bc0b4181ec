// Someone opens another scene, records, downloads, looks back in time, and finds out that another page sees the same.

import { readFileSync } from "node:fs";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import {
  difference,
  largestMove,
  launch,
  memoryOf,
  middle,
  open,
  pause,
  positions,
  screenshot,
  state,
  still,
} from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  ({ page, problems } = await open(browser, server.url));
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

describe("the timeline", () => {
  it("shows the past while the present goes on, and comes back", async () => {
    await page.waitForFunction(() => window.tetfront!.moments() > 40);
    const target = 0.5 + Number(await page.getAttribute(".timeline", "min"));
    await page.$eval(
      ".timeline",
      (slider, time) => {
        (slider as HTMLInputElement).value = String(time);
        slider.dispatchEvent(new Event("input"));
      },
      target,
    );
    await page.waitForFunction(() => window.tetfront!.state().scrub !== null);
    await page.waitForTimeout(300);
    const past = await page.evaluate(() => window.tetfront!.frame()!.time);
    // The last of the kept frames that is not after the moment, however far apart they are.
    const wanted = (await state(page)).scrub!;
    expect(wanted).toBeCloseTo(target, 6);
    const kept = await page.evaluate(() => window.tetfront!.times());
    expect(past).toBe(kept.filter((time) => time <= wanted + 1e-9).at(-1));
    const before = await positions(page);
    const { time } = (await state(page)).simulation!;
    await page.waitForTimeout(600);
    expect(largestMove(before, await positions(page))).toBe(0);
    expect((await state(page)).simulation!.time).toBeGreaterThan(time);
    expect(await page.innerText(".pill")).toBe("looking back");
    await screenshot(page, "looking_back");
    await page.keyboard.press("l");
    await page.waitForFunction((t) => window.tetfront!.frame()!.time > t, time);
    expect(await page.isVisible("button.live")).toBe(false);
  });
});

describe("recording", () => {
  it("starts, counts, ends and is there to download", async () => {
    await page.keyboard.press("v");
    await page.waitForFunction(() => window.tetfront!.state().recording?.active);
    expect(await page.getAttribute("button.record", "aria-label")).toBe("End the recording");
    await page.waitForTimeout(400);
    await page.keyboard.press("v");
    await page.waitForFunction(() => window.tetfront!.state().recording?.active === false);
    await page.click("[aria-controls=panel]");
    await page.click("text=Recordings …");
    await page.waitForSelector(".files a");
    await screenshot(page, "recordings");
    const [download] = await Promise.all([page.waitForEvent("download"), page.click(".files a")]);
    expect(download.suggestedFilename()).toBe("mock-1.tfr");
    expect(readFileSync(await download.path(), "utf8")).toBe("recording mock-1.tfr");
    await page.evaluate(() => (window.showSaveFilePicker = undefined)); // save.story.ts has the other way
    const [pictures] = await Promise.all([page.waitForEvent("download"), page.click(".files >> text=Pictures")]);
    expect(pictures.suggestedFilename()).toBe("mock-1.zip");
    expect(readFileSync(await pictures.path(), "utf8")).toBe("recording mock-1.tfr/frames.zip");
    await page.click(".files >> text=Video");
    await page.waitForSelector("text=Video: there is no ffmpeg here; install it");
    await screenshot(page, "recordings_problem");
    // The browser itself logs that the answer was 422.
    expect(problems.splice(0)).toEqual([expect.stringContaining("422")]);
    await page.keyboard.press("Escape");
    await page.click("[aria-controls=panel]");
  });
});

describe("two pages", () => {
  it("see the same, and know of each other", async () => {
    const { page: other } = await open(browser, server.url);
    await page.waitForFunction(() => window.tetfront!.state().simulation?.viewers === 2);
    expect(await page.innerText(".pill")).toContain("2 viewers");
    await pause(page);
    await still(other);
    expect(largestMove(await positions(page), await positions(other))).toBe(0);
    expect(difference(await middle(page), await middle(other))).toBeLessThan(0.01);
    await other.close();
    await page.waitForFunction(() => window.tetfront!.state().simulation?.viewers === 1);
  });
});

describe("another scene", () => {
  it("comes from a list of titles", async () => {
    const vertices = (await positions(page)).length;
    await page.keyboard.press("o");
    await page.waitForSelector(".cards [aria-current]");
    expect(await page.innerText(".cards [aria-current]")).toContain("open now");
    // One of the two has a thumbnail.
    await page.waitForSelector(".cards img:not([hidden])");
    await page.waitForLoadState("networkidle");
    expect(await page.locator(".cards img:not([hidden])").count()).toBe(1);
    await screenshot(page, "scenes");
    await page.click("text=A coarser ball");
    await page.waitForFunction(() => document.querySelector("h1")?.textContent === "A coarser ball (mock)");
    await page.waitForFunction((n) => window.tetfront!.positions()!.length !== n || n === 258 * 3, vertices);
    expect((await state(page)).settings?.forces).toEqual([]);
  });

  it("keeps memory flat over many changes", async () => {
    const load = async (name: string) => {
      server.simulation.load({ name, title: name, detail: 3 });
      await page.waitForFunction(
        (wanted) => window.tetfront!.state().hello?.scene.name === wanted && window.tetfront!.frame(),
        name,
      );
      await still(page);
    };
    for (let i = 0; i < 5; ++i) await load(`warm ${i}`);
    const before = await memoryOf(page);
    for (let i = 0; i < 50; ++i) await load(`scene ${i}`);
    const after = await memoryOf(page);
    expect(after.gpu).toEqual(before.gpu);
    expect(after.heap / before.heap).toBeLessThan(1.15);
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
