// The main job against the real program: `tetfront serve` with a small scene, from the first view to a restart.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { Program, writeScene } from "./program";
import {
  difference,
  largestMove,
  launch,
  middle,
  open,
  pause,
  pointOnObject,
  positions,
  screenshot,
  state,
  still,
} from "./support";

describe("tetfront serve and its page", () => {
  let browser: Browser;
  let server: Program;
  let page: Page;
  let problems: string[];
  let file: string;

  beforeAll(async () => {
    file = writeScene();
    browser = await launch();
    server = await Program.serve(file);
    ({ page, problems } = await open(browser, server.url));
  });
  afterAll(async () => {
    await browser?.close();
    await server?.stop("SIGKILL");
  });

  it("shows the object", async () => {
    const pixels = await middle(page, "end_to_end");
    expect(pixels.colours).toBeGreaterThan(100);
    expect(pixels.spread).toBeGreaterThan(15);
    expect(await page.textContent("h1")).toBe("A soft bar");
  });

  it("bends under its weight", async () => {
    // From rest: by now it may have come to its equilibrium.
    await pause(page);
    await page.keyboard.press("r");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.time === 0);
    await still(page);
    const before = await positions(page);
    await page.keyboard.press("Space");
    await page.waitForFunction(() => (window.tetfront!.state().simulation?.time ?? 0) > 0.5);
    expect(largestMove(before, await positions(page))).toBeGreaterThan(1e-3);
  });

  it("stops, steps and resets", async () => {
    await pause(page);
    const stopped = await positions(page);
    const { step } = (await state(page)).simulation!;
    await page.waitForTimeout(500);
    expect(largestMove(stopped, await positions(page))).toBe(0);
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction((n) => window.tetfront!.state().simulation!.step === n, step + 1);
    await page.keyboard.press("r");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.time === 0);
    await still(page);
    const rest = await positions(page);
    for (let i = 0; i < rest.length; i += 3) {
      expect(Math.abs(rest[i] - 0.15)).toBeLessThan(0.1501);
      expect(Math.abs(rest[i + 2] - 0.45)).toBeLessThan(0.4501);
    }
  });

  it("colours by stiffness, with the scene's range in the legend", async () => {
    const level = await middle(page);
    await page.keyboard.press("c");
    await still(page);
    expect(difference(level, await middle(page, "end_to_end_stiffness"))).toBeGreaterThan(0.1);
    const legend = (await page.innerText(".legend")).replace(/\s+/g, " ");
    expect(legend).toMatch(/Young’s modulus 1\d\d kPa .* [12](\.\d+)? MPa soft/);
    await page.keyboard.press("c");
  });

  it("shows as many solid tets as the server counts", async () => {
    await pause(page);
    await page.keyboard.press("e");
    await still(page);
    const counted = (await state(page)).simulation!.tets_by_level.reduce((a, b) => a + b, 0);
    expect(counted).toBeGreaterThan(100);
    expect(await page.evaluate(() => window.tetfront!.census().tets)).toBe(counted);
    await screenshot(page, "end_to_end_tets");
    await page.keyboard.press("e");
  });

  it("gives way to a pull more than to none", async () => {
    const gravity = page.locator("[aria-label^='Gravity along']");
    await page.click("[aria-controls=panel]");
    for (let i = 0; i < 3; ++i) {
      await gravity.nth(i).fill("0");
      await page.keyboard.press("Enter");
    }
    await page.click("[aria-controls=panel]");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.gravity.every((g) => g === 0));
    await page.keyboard.press("r");
    await page.keyboard.press("Space");
    const at = await pointOnObject(page);
    const rest = await positions(page);
    await page.waitForTimeout(1000);
    expect(largestMove(rest, await positions(page))).toBeLessThan(1e-3);

    await page.mouse.down();
    await page.mouse.move(at.x + 40, at.y, { steps: 4 });
    await page.mouse.move(at.x + 80, at.y, { steps: 4 });
    await page.waitForFunction(() => (window.tetfront!.frame()?.pulls.length ?? 0) > 0);
    await page.waitForTimeout(1500);
    await screenshot(page, "end_to_end_pull");
    expect(largestMove(rest, await positions(page))).toBeGreaterThan(0.02);
    expect(await page.innerText("output.force:not([hidden])")).toMatch(/^[\d.]+ k?N$/);
    await page.mouse.up();
    await page.waitForFunction(() => window.tetfront!.frame()?.pulls.length === 0);
  });

  it("keeps to the levels that are chosen", async () => {
    await page.click("[aria-controls=panel]");
    const tets = async () => (await state(page)).simulation!.tets_by_level;
    expect((await tets())[0]).toBeGreaterThan(0);
    await page.selectOption("[aria-label='Coarsest level']", "1");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.tets_by_level[0] === 0);
    expect((await tets())[1]).toBeGreaterThan(0);
    await page.click("[aria-label='Reset levels']");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.tets_by_level[0] > 0);
    await page.click("[aria-controls=panel]");
  });

  it("tells what was refused", async () => {
    await page.click("[aria-controls=panel]");
    await page.$eval("[aria-label='Tolerance in percent']", (input) => input.removeAttribute("max"));
    await page.fill("[aria-label='Tolerance in percent']", "900");
    await page.keyboard.press("Enter");
    await page.waitForSelector(".toast");
    expect(await page.innerText(".toasts")).toMatch(/Tolerance: .*9/);
    await page.click("[aria-controls=panel]");
  });

  it("ends with status 0 at SIGTERM, and the page finds the next server", async () => {
    expect(problems).toEqual([]);
    const { port } = server;
    expect(await server.stop()).toBe(0);
    await page.waitForSelector(".banner .countdown");
    server = await Program.serve(file, port);
    await page.waitForFunction(
      () => window.tetfront!.state().link.status === "open" && window.tetfront!.state().simulation,
    );
    const before = await positions(page);
    await page.waitForTimeout(700);
    expect(largestMove(before, await positions(page))).toBeGreaterThan(1e-4);
  });
});
