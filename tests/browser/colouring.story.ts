// Each way to look at the object changes pixels and the legend; the address carries it to another page.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { difference, launch, middle, open, pause, state, still } from "./support";
import type { Pixels } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  ({ page, problems } = await open(browser, server.url));
  await page.waitForFunction(() => (window.tetfront!.frame()?.time ?? 0) > 0.4);
  await pause(page);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const legend = async () => (await page.innerText(".legend")).replace(/\s+/g, " ");

describe("the key C", () => {
  const seen: Pixels[] = [];
  it.each([
    ["level", /^Level of refinement 0 coarsest 720/],
    ["stiffness", /^Young’s modulus 100 kPa 1 MPa 10 MPa soft log scale stiff/],
    ["displacement", /^Displacement 0 [mc]m [\d.]+ [mc]m [\d.]+ [mc]m/],
    ["strain", /^Equivalent strain 0 % 10 % 20 %/],
    ["stress", /^Von Mises stress 0 Pa 100 kPa 200 kPa/],
    ["error", /^Part of the error estimate 0 %/],
  ])("shows %s, and what it means", async (colouring, text) => {
    expect((await state(page)).colouring).toBe(colouring);
    await page.waitForFunction(() => !document.querySelector(".legend")!.textContent!.includes("Waiting"));
    await still(page);
    const pixels = await middle(page, `colouring_${colouring}`);
    expect(await legend()).toMatch(text);
    // strain and stress of the mock differ in their unit only
    for (const other of colouring === "stress" ? seen.slice(0, 3) : seen)
      expect(difference(other, pixels)).toBeGreaterThan(0.1);
    seen.push(pixels);
    await page.keyboard.press("c");
  });

  it("comes back to the first", async () => {
    await still(page);
    expect(difference(seen[0], await middle(page))).toBe(0);
  });
});

describe("the shape", () => {
  it("opens by the cut, and closes again", async () => {
    const whole = await middle(page);
    await page.keyboard.press("x");
    await still(page);
    expect(difference(whole, await middle(page, "cut"))).toBeGreaterThan(0.1);
    await page.keyboard.press("x");
    await still(page);
    expect(difference(whole, await middle(page))).toBe(0);
  });

  it("is solid tetrahedra, which come apart", async () => {
    const surface = await middle(page);
    await page.keyboard.press("e");
    await still(page);
    const tets = await middle(page, "tets");
    expect(await page.evaluate(() => window.tetfront!.census().tets)).toBe(server.simulation.front.tetLevels.length);
    expect(difference(surface, tets)).toBeGreaterThan(0.1);
    await page.click("[aria-controls=panel]");
    await page.fill("[aria-label='Explode in percent']", "50");
    await page.keyboard.press("Enter");
    await page.click("[aria-controls=panel]");
    await still(page);
    expect(difference(tets, await middle(page, "exploded"))).toBeGreaterThan(0.1);
  });
});

describe("the address", () => {
  it("shows the same on another page, and acts on the simulation", async () => {
    await page.click("[aria-controls=panel]");
    await page.fill("[aria-label='Stiffness scale in ×']", "4");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.state().settings?.stiffness_scale === 4);
    await page.waitForFunction(() => location.hash.includes("stiffness=4") && location.hash.includes("shape=tets"));
    const address = page.url();
    server.simulation.stiffness = 1;
    const other = await browser.newPage({ viewport: { width: 640, height: 360 } });
    await other.goto(address);
    await other.waitForFunction(() => window.tetfront?.state().settings?.stiffness_scale === 4);
    expect((await state(other)).shape).toBe("tets");
    expect(server.simulation.stiffness).toBe(4);
    await other.close();
  });

  it("forgets what goes back to the scene's value", async () => {
    await page.click("[aria-label='Reset stiffness scale']");
    await page.waitForFunction(() => window.tetfront!.state().settings?.stiffness_scale === 1);
    await page.waitForFunction(() => !location.hash.includes("stiffness"));
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
