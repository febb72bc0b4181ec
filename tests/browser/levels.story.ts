// Levels of the panel: what is chosen, what the order leaves to choose, and the way back.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { launch, open, screenshot, state } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];
beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3, playing: false });
  ({ page, problems } = await open(browser, server.url));
  await page.click("[aria-controls=panel]");
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const chosen = async () => [await page.inputValue("[aria-label='Coarsest level']"), await page.inputValue("[aria-label='Finest level']")]; // prettier-ignore
const settled = (min: number, max: number) =>
  page.waitForFunction(
    ([low, high]) => {
      const levels = window.tetfront!.state().settings?.levels;
      return levels?.min === low && levels.max === high;
    },
    [min, max] as const,
  );
const sent = () => server.simulation.commands.filter(({ command }: { command: string }) => command === "levels");

describe("levels", () => {
  it("begin with all that the scene has", async () => {
    expect(await chosen()).toEqual(["0", "2"]);
    expect(await page.locator("[aria-label='Finest level'] option").allTextContents()).toEqual(["0", "1", "2"]);
    expect(await page.isVisible("[aria-label='Reset levels']")).toBe(false);
  });

  it("act at once, and one end takes the other along", async () => {
    await page.selectOption("[aria-label='Finest level']", "1");
    await settled(0, 1);
    await page.selectOption("[aria-label='Coarsest level']", "2");
    await settled(2, 2);
    expect(await chosen()).toEqual(["2", "2"]);
    await page.selectOption("[aria-label='Finest level']", "1");
    await settled(1, 1);
    await page.waitForFunction(() => location.hash.includes("levels=1,1"));
    await page.locator("[aria-label='Reset levels']").scrollIntoViewIfNeeded();
    await screenshot(page, "levels");
  });

  it("go back to the scene's", async () => {
    await page.click("[aria-label='Reset levels']");
    await settled(0, 2);
    expect(await page.isVisible("[aria-label='Reset levels']")).toBe(false);
    expect(sent().at(-1)).toMatchObject({ min: 0, max: 99 });
  });

  it("follow the order", async () => {
    const radio = (order: string) => page.click(`label:has(> input[name='Order of the tetrahedra'][value='${order}'])`);
    await radio("2");
    await settled(0, 1);
    expect(await page.locator("[aria-label='Finest level'] option").count()).toBe(2);
    expect(await page.isVisible("[aria-label='Reset levels']"), "nobody chose them").toBe(false);
    await page.selectOption("[aria-label='Coarsest level']", "1");
    await settled(1, 1);
    await radio("1");
    await settled(1, 2); // the finest is still the finest
    await page.click("[aria-label='Reset levels']");
    await settled(0, 2);
  });

  it("of a link act on the simulation", async () => {
    await page.selectOption("[aria-label='Coarsest level']", "1");
    await page.waitForFunction(() => location.hash.includes("levels=1,99"));
    const address = page.url();
    server.simulation.wantedLevels = { min: 0, max: 99 };
    const other = await browser.newPage({ viewport: { width: 640, height: 360 } });
    await other.goto(address);
    await other.waitForFunction(() => window.tetfront?.state().settings?.levels?.min === 1);
    expect((await state(other)).settings?.levels).toEqual({ min: 1, max: 2 });
    await other.close();
  });

  it("have made no errors", () => expect(problems).toEqual([]));
});
