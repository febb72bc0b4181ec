// Someone grabs the object and pulls. What no drag does is measured beside it.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { largestMove, launch, open, pause, pointOnObject, positions, screenshot, still } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];
const sent = () => server.simulation.commands.map(({ command }: { command: string }) => command);

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer();
  server.simulation.gravity = [0, 0, 0]; // no sway: what moves, is pulled
  ({ page, problems } = await open(browser, server.url));
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

describe("pulling", () => {
  it("moves the object; moving the pointer without a button does not", async () => {
    const at = await pointOnObject(page);
    const rest = await positions(page);
    await page.mouse.move(at.x - 60, at.y - 40, { steps: 4 });
    await page.waitForTimeout(500);
    expect(largestMove(rest, await positions(page))).toBeLessThan(1e-4);
    expect(sent()).toEqual([]);

    await page.mouse.move(at.x, at.y);
    await page.mouse.down();
    await page.mouse.move(at.x - 30, at.y - 20, { steps: 3 });
    await page.mouse.move(at.x - 60, at.y - 40, { steps: 3 });
    await page.waitForFunction(() => (window.tetfront!.frame()?.pulls.length ?? 0) > 0);
    await page.waitForTimeout(700);
    expect(largestMove(rest, await positions(page))).toBeGreaterThan(0.05);
    await screenshot(page, "pull");
    expect(await page.innerText("output.force:not([hidden])")).toMatch(/^[\d.]+ N$/);
    expect(await page.getAttribute("#view", "class")).toContain("pulling");

    await page.mouse.up();
    await page.waitForFunction(() => window.tetfront!.frame()?.pulls.length === 0);
    await page.waitForTimeout(1200);
    expect(largestMove(rest, await positions(page))).toBeLessThan(0.01);
    expect(await page.isVisible("output.force")).toBe(false);
    expect(sent()[0]).toBe("pull_begin");
    expect(sent().filter((command: string) => command === "pull_move").length).toBeGreaterThan(0);
    expect(sent().at(-1)).toBe("pull_end");
  });

  it("grabs the point under the pointer", () => {
    const begin = server.simulation.commands.find(({ command }: { command: string }) => command === "pull_begin");
    expect(begin.barycentric.reduce((a: number, b: number) => a + b)).toBeCloseTo(1, 9);
    const held = server.simulation.at(server.simulation.shape.rest, begin);
    // The hand has moved only a few pixels when the pull begins: metres away would be another point.
    expect(Math.hypot(...held.map((x: number, i: number) => x - begin.target[i]))).toBeLessThan(0.2);
  });

  it("does not disturb the object by a click, a right drag, or a drag beside it", async () => {
    const before = sent().length;
    const at = await pointOnObject(page);
    await page.mouse.click(at.x, at.y);
    await page.mouse.down({ button: "right" });
    await page.mouse.move(at.x + 30, at.y, { steps: 3 });
    await page.mouse.up({ button: "right" });
    await page.mouse.move(60, 110);
    await page.mouse.down();
    await page.mouse.move(90, 110, { steps: 3 });
    await page.mouse.up();
    expect(sent().length).toBe(before);
    await page.keyboard.press("f");
  });

  it("looks at a point by a double-click", async () => {
    await pause(page);
    const at = await pointOnObject(page);
    const before = sent().length;
    const redraws = await page.evaluate(() => window.tetfront!.redraws());
    await page.mouse.dblclick(at.x, at.y);
    await still(page);
    expect(await page.evaluate(() => window.tetfront!.redraws())).toBeGreaterThan(redraws);
    expect(sent().length).toBe(before);
  });

  it("needs no pointer: a key grabs, arrows move, Enter lets go", async () => {
    await page.keyboard.press("f");
    await page.keyboard.press("Space");
    await page.mouse.move(20, 20); // on the page's title: the key means the middle
    const before = sent().length;
    const rest = await positions(page);
    await page.keyboard.press("ArrowUp"); // moves nothing yet
    await page.keyboard.press("d");
    await page.waitForFunction(() => (window.tetfront!.frame()?.pulls.length ?? 0) > 0);
    expect(await page.innerText(".banners")).toMatch(/Arrow keys/);
    await page.waitForTimeout(500);
    expect(largestMove(rest, await positions(page))).toBeLessThan(0.01);
    for (let i = 0; i < 8; ++i) await page.keyboard.press("ArrowRight");
    for (let i = 0; i < 4; ++i) await page.keyboard.press("PageUp");
    await page.waitForTimeout(700);
    await screenshot(page, "pull_by_keys");
    expect(largestMove(rest, await positions(page))).toBeGreaterThan(0.05);
    const [begin, ...moves] = server.simulation.commands.slice(before);
    expect(begin.command).toBe("pull_begin");
    expect(moves.every(({ command }: { command: string }) => command === "pull_move")).toBe(true);
    const way = moves.at(-1).target.map((x: number, i: number) => x - begin.target[i]);
    // Eight steps to the right and four nearer, of 4 % of the ball's half diagonal.
    expect(Math.hypot(...way)).toBeCloseTo(Math.hypot(8, 4) * 0.04 * Math.sqrt(0.75), 6);
    expect(way[0]).toBeGreaterThan(0.2);
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.frame()?.pulls.length === 0);
    expect(sent().at(-1)).toBe("pull_end");
    expect(await page.innerText(".banners")).toBe("");
  });

  it("ends a pull by keys when the keyboard goes elsewhere", async () => {
    const pulls = () => page.evaluate(() => window.tetfront!.frame()?.pulls.length);
    await page.keyboard.press("d");
    await page.waitForFunction(() => (window.tetfront!.frame()?.pulls.length ?? 0) > 0);
    await page.waitForTimeout(400);
    expect(await pulls()).toBeGreaterThan(0);
    await page.keyboard.press("Tab");
    await page.waitForFunction(() => window.tetfront!.frame()?.pulls.length === 0);
  });

  it("is ended when the scene comes anew under a hand that holds it", async () => {
    const place = server.simulation.scene;
    await page.keyboard.press("d");
    await page.waitForFunction(() => (window.tetfront!.frame()?.pulls.length ?? 0) > 0);
    server.simulation.load(place);
    await page.waitForFunction(() => !window.tetfront!.state().pullsByKeys);
    await expect.poll(() => sent().at(-1)).toBe("pull_end");
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
