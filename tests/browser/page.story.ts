// The page itself: both themes, small screens, the help sheet, and what axe-core finds.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import type { AxeResults } from "axe-core";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { launch, open, screenshot } from "./support";

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
  ["light", 1000, 700],
  ["dark", 800, 600],
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
    // The panel may lie over the picture's own cards in a narrow window, but these not over each other, nor over it in a wide one.
    const alone = [".toolbar", ".legend", ".heading", ".corner", ...(width >= 720 ? ["#panel", "#plots"] : [])];
    expect(await overlapping(page, alone)).toEqual([]);
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

it("remembers the theme that was chosen", async () => {
  const context = await browser.newContext({ colorScheme: "light" });
  const page = await context.newPage();
  const theme = () => page.getAttribute("html", "data-theme");
  await page.goto(server.url);
  expect(await theme()).toBe("light");
  await page.keyboard.press("t");
  expect(await theme()).toBe("dark");
  await page.reload();
  expect(await theme()).toBe("dark");
  await context.close();
});
