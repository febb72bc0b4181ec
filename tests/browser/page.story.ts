// The page itself: both themes, small screens, the help sheet, and what axe-core finds.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import type { AxeResults } from "axe-core";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { launch, open, screenshot, shown, still } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3, playing: false });
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const web = createRequire(new URL("../../web/package.json", import.meta.url));
const axe = readFileSync(web.resolve("axe-core/axe.min.js"), "utf8");
async function violations(page: Page): Promise<string[]> {
  await page.evaluate(axe);
  const run = () => (window as unknown as { axe: { run(): Promise<AxeResults> } }).axe.run();
  const { violations: found } = await page.evaluate(run);
  return found.flatMap(({ id, nodes }) => nodes.map(({ target }) => `${id}: ${target.join(" ")}`));
}

/** Pairs of visible elements that lie over each other. */
const overlapping = (page: Page, selectors: string[]): Promise<string[]> =>
  page.evaluate((list) => {
    const boxes = list
      .map((selector) => ({ selector, box: document.querySelector(selector)!.getBoundingClientRect() }))
      .filter(({ box }) => box.width > 0);
    return boxes.flatMap((a, i) =>
      boxes
        .slice(i + 1)
        .filter(
          ({ box }) =>
            a.box.left < box.right && box.left < a.box.right && a.box.top < box.bottom && box.top < a.box.bottom,
        )
        .map((b) => `${a.selector} ${b.selector}`),
    );
  }, selectors);

describe.each([
  ["light", 1280, 720],
  ["dark", 1280, 720],
  ["light", 360, 640],
  ["dark", 360, 640],
  ["dark", 640, 360],
] as const)("the page, %s, %d x %d", (theme, width, height) => {
  it("keeps everything inside the window and passes axe", async () => {
    const { page, problems } = await open(browser, server.url, {
      width,
      height,
      dark: theme === "dark",
      quality: "full",
    });
    await page.waitForTimeout(300);
    await screenshot(page, `page_${theme}_${width}`);
    expect(await violations(page)).toEqual([]);
    if (!(await page.isVisible("#panel"))) await page.click("[aria-controls=panel]");
    await screenshot(page, `panel_${theme}_${width}`);
    expect(await violations(page)).toEqual([]);
    for (const card of await page.$$(".card")) {
      const box = await card.boundingBox();
      if (!box) continue;
      expect(box.x).toBeGreaterThanOrEqual(0);
      expect(box.y).toBeGreaterThanOrEqual(0);
      expect(box.x + box.width).toBeLessThanOrEqual(width);
      expect(box.y + box.height).toBeLessThanOrEqual(height);
    }
    await page.keyboard.press("?");
    expect(await page.isVisible("dialog")).toBe(true);
    expect(await page.innerText("dialog")).toMatch(/Play or pause/);
    await screenshot(page, `help_${theme}_${width}`);
    expect(await violations(page)).toEqual([]);
    await page.keyboard.press("Escape");
    expect(await page.isVisible("dialog")).toBe(false);
    expect(problems).toEqual([]);
    await page.close();
  });
});

it("keeps its cards apart in windows of any width, while it records too", async () => {
  const { page } = await open(browser, server.url, { width: 1280, height: 760 });
  await page.keyboard.press("v");
  for (const width of [1280, 1100, 1099, 1000, 860, 859, 720, 600, 480, 360]) {
    await page.setViewportSize({ width, height: 760 });
    for (const open of ["panel", "plots"]) {
      if (!(await page.isVisible(`#${open}`))) await page.click(`[aria-controls=${open}]`);
      await page.waitForTimeout(100);
      // Where the window is narrow, a dock is a sheet over the picture's own cards.
      const alone = [".toolbar", ".legend", ".heading", ".corner", ...(width >= 860 ? ["#panel", "#plots"] : [])];
      expect(await overlapping(page, alone), `${width} with ${open}`).toEqual([]);
      const { x, width: wide } = (await page.locator(".toolbar").boundingBox())!;
      expect(x >= 0 && x + wide <= width, `the toolbar at ${width}`).toBe(true);
    }
    if (width === 1000) await screenshot(page, "width_1000");
  }
  await page.keyboard.press("v");
  await page.close();
});

it.each(["light", "dark"])("passes axe with its lists, a force, a part, a tool and a toast open, %s", async (theme) => {
  server.simulation.recordings = [{ name: "mock-20260131-235959.tfr", bytes: 1e6 }];
  const { page } = await open(browser, server.url, { width: 900, height: 640, dark: theme === "dark" });
  await page.mouse.move(200, 300);
  await page.keyboard.press("n");
  await page.waitForSelector(".loads li");
  expect(await page.getAttribute(".loads li", "class")).toBe("selected");
  await page.$eval(".loads li", (item) => item.scrollIntoView());
  server.simulation.tell({ type: "log", level: "warning", message: "the server shuts down soon" });
  await page.waitForSelector(".toast");
  await screenshot(page, `force_${theme}`);
  expect(await violations(page)).toEqual([]);
  await page.keyboard.press("k");
  await page.waitForSelector(".parts li");
  await page.click("button.tool:text('Stiffer')");
  await page.waitForSelector(".banner");
  await page.$eval(".parts", (list) => list.scrollIntoView());
  await screenshot(page, `parts_${theme}`);
  expect(await violations(page)).toEqual([]);
  await page.click(".banner button");
  expect(await page.locator(".banner").count()).toBe(0);
  await page.click("text=Recordings …");
  await page.waitForSelector(".files button");
  expect(await violations(page)).toEqual([]);
  await page.keyboard.press("Escape");
  await page.keyboard.press("o");
  await page.waitForSelector(".cards button");
  expect(await violations(page)).toEqual([]);
  await page.close();
  server.simulation.forces = [];
  server.simulation.stiffnessParts = [];
});

it("has room for a long run, a recording and the past at 360 pixels", async () => {
  const busy = await startMockServer({ detail: 3 });
  busy.simulation.step = 60 * 3599;
  const { page } = await open(browser, busy.url, { width: 360, height: 640 });
  const misfits = () =>
    page.evaluate(() => {
      const bar = document.querySelector(".toolbar")!;
      const frame = bar.getBoundingClientRect();
      return [...bar.children]
        .map((child) => ({ name: child.className, box: child.getBoundingClientRect() }))
        .filter(({ box }) => box.width > 0)
        .filter(({ box }) => box.left < frame.left || box.right > frame.right || frame.right > innerWidth)
        .map(({ name }) => name);
    });
  await page.keyboard.press("v");
  await page.waitForFunction(() => window.tetfront!.state().recording?.active);
  await page.waitForFunction(() => window.tetfront!.moments() > 20);
  expect(await page.innerText(".clock")).toMatch(/^\d\d:\d\d\.\d$/);
  await screenshot(page, "narrow_recording");
  expect(await misfits()).toEqual([]);
  const { width, height } = (await page.locator("button.primary").boundingBox())!;
  expect(width).toBe(height);
  await page.focus(".timeline");
  await page.keyboard.press("Home");
  await page.waitForSelector("button.live");
  await screenshot(page, "narrow_past");
  expect(await misfits()).toEqual([]);
  await page.close();
  await busy.close();
});

it.each(["light", "dark"])("takes a tool into the hand at 360 pixels and out again, %s", async (theme) => {
  const { page } = await open(browser, server.url, { width: 360, height: 640, dark: theme === "dark" });
  await page.click("[aria-controls=panel]");
  await page.click("button.tool:text('Stiffer')");
  expect(await page.isVisible("#panel")).toBe(false);
  await page.mouse.click(180, 310);
  await page.waitForSelector("output.part:not([hidden])");
  await screenshot(page, `tool_${theme}_360`);
  const box = (await page.locator(".banner").boundingBox())!;
  expect(box.x >= 0 && box.x + box.width <= 360).toBe(true);
  expect(await overlapping(page, [".banner", ".heading", ".corner", ".legend", ".toolbar"])).toEqual([]);
  expect(await violations(page)).toEqual([]);
  await page.click(".banner button");
  await page.click("[aria-controls=panel]");
  await page.waitForSelector(".parts li");
  await page.$eval(".parts", (list) => list.scrollIntoView());
  await screenshot(page, `parts_${theme}_360`);
  const misfits = await page.$$eval(
    ".parts li > *",
    (cells) =>
      cells.filter((cell) => cell.scrollWidth > cell.clientWidth || cell.getBoundingClientRect().right > innerWidth)
        .length,
  );
  expect(misfits).toBe(0);
  expect(await violations(page)).toEqual([]);
  await page.close();
  server.simulation.stiffnessParts = [];
});

it("moves nothing by itself for those who want less motion", async () => {
  const { page } = await open(browser, server.url);
  /** How the record button blinks, and redraws until the camera has arrived. */
  const motion = async (zooms: string) => {
    await page.keyboard.press("v");
    await page.waitForSelector("button.record.active");
    const blinks = await page.$eval("button.record svg", (svg) => getComputedStyle(svg).animationName);
    const slides = await page.$eval("#view", (view) => getComputedStyle(view).transitionDuration);
    await page.keyboard.press("v");
    await page.waitForSelector("button.record:not(.active)");
    await page.keyboard.press(zooms);
    await still(page);
    const before = await page.evaluate(() => window.tetfront!.redraws());
    await page.keyboard.press("f");
    await still(page);
    return { blinks, slides, redraws: (await page.evaluate(() => window.tetfront!.redraws())) - before };
  };
  const usual = await motion("PageUp");
  expect(usual).toMatchObject({ blinks: "blink", slides: "0.3s" });
  expect(usual.redraws).toBeGreaterThan(2);
  await page.emulateMedia({ reducedMotion: "reduce" });
  const reduced = await motion("PageDown");
  expect(reduced).toMatchObject({ blinks: "none", slides: "0s" });
  expect(reduced.redraws).toBeLessThanOrEqual(2);
  await page.close();
});

it("remembers the theme that was chosen", async () => {
  const context = await browser.newContext({ colorScheme: "light" });
  const page = await context.newPage();
  const theme = () => page.getAttribute("html", "data-theme");
  await page.goto(server.url);
  await shown(page);
  expect(await theme()).toBe("light");
  await page.keyboard.press("t");
  expect(await theme()).toBe("dark");
  await page.reload();
  await shown(page);
  expect(await theme()).toBe("dark");
  await context.close();
});
