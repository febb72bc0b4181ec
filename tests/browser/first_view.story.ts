// Someone opens the page: the object is there, moves, can be stopped, stepped, reset, and coloured in another way.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { difference, largestMove, launch, middle, open, pause, positions, shown, state, still } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer();
  ({ page, problems } = await open(browser, server.url));
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

describe("first view", () => {
  it("shows the object, not a blank canvas", async () => {
    const pixels = await middle(page, "first_view");
    expect(pixels.colours).toBeGreaterThan(100);
    expect(pixels.spread).toBeGreaterThan(20);
    expect(await page.textContent("h1")).toBe("Wobbling ball (mock)");
    expect(await page.title()).toContain("Wobbling ball");
  });

  it("moves while it plays", async () => {
    const before = await positions(page);
    await page.waitForTimeout(400);
    expect(largestMove(before, await positions(page))).toBeGreaterThan(0.005);
  });

  it("tells the numbers with their units", async () => {
    await page.click("[aria-controls=panel]");
    const text = (await page.innerText("#panel")).replace(/\s+/g, " ");
    expect(text).toContain("60 steps/s in real time");
    expect(text).toContain("1 600 tetrahedra 412 vertices");
    expect(text).toContain("3.4 % error estimate tolerance 5 %");
    expect((await page.innerText(".legend")).replace(/\s+/g, " ")).toContain("0 coarsest 720 1 880 2 finest 0");
    await page.click("[aria-controls=panel]");
    expect(await page.isVisible("#panel")).toBe(false);
  });

  it("stops, goes one step, and back to rest", async () => {
    await pause(page);
    const stopped = await positions(page);
    await page.waitForTimeout(400);
    expect(largestMove(stopped, await positions(page))).toBe(0);

    const { step } = (await state(page)).simulation!;
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction((n) => window.tetfront!.state().simulation!.step === n, step + 1);
    await still(page);
    expect(largestMove(stopped, await positions(page))).toBeGreaterThan(1e-5);

    await page.click("[aria-label=Reset]");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.time === 0);
    await still(page);
    const rest = server.simulation.shape.rest;
    expect(largestMove([...rest], await positions(page))).toBeLessThan(1e-4);
    expect(await page.innerText("output.clock")).toBe("0.00 s");
  });

  it("colours by level and by stiffness, with a legend for each", async () => {
    await pause(page);
    const level = await middle(page);
    expect(await page.innerText(".legend")).toContain("Level of refinement");
    await page.keyboard.press("c");
    await still(page);
    const stiffness = await middle(page, "stiffness");
    expect(difference(level, stiffness)).toBeGreaterThan(0.2);
    const legend = (await page.innerText(".legend")).replace(/\s+/g, " ");
    expect(legend).toContain("Young’s modulus 100 kPa 1 MPa 10 MPa soft log scale stiff");
    for (let i = 0; i < 5; ++i) await page.keyboard.press("c"); // once around
    await still(page);
    expect(difference(level, await middle(page))).toBe(0);
  });

  it("shows the front's wireframe", async () => {
    const without = await middle(page);
    await page.keyboard.press("w");
    await still(page);
    expect(difference(without, await middle(page, "wireframe"))).toBeGreaterThan(0.05);
    await page.keyboard.press("w");
    await still(page);
    expect(difference(without, await middle(page))).toBe(0);
  });

  it("orbits by mouse and by keys, and comes home", async () => {
    const home = await middle(page);
    await page.mouse.move(80, 110);
    await page.mouse.down();
    await page.mouse.move(180, 80, { steps: 4 });
    await page.mouse.up();
    await still(page);
    expect(difference(home, await middle(page))).toBeGreaterThan(0.05);
    await page.keyboard.press("f");
    await still(page);
    expect(difference(home, await middle(page))).toBeLessThan(0.01);
    await page.keyboard.press("Shift+ArrowLeft");
    await still(page);
    expect(difference(home, await middle(page))).toBeGreaterThan(0.02);
    await page.keyboard.press("f");
    await still(page);
  });

  it("sends tolerance and gravity, and gives refused values back", async () => {
    await page.click("[aria-controls=panel]");
    await page.fill("[aria-label='Tolerance in percent']", "2.5");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.tolerance === 0.025);
    await page.fill("[aria-label^='Gravity along x']", "3");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.gravity[0] === 3);
    await page.click("[aria-label='Reset gravity']");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.gravity[0] === 0);
    expect(await page.inputValue("[aria-label^='Gravity along x']")).toBe("0");
    await page.selectOption("[aria-label=Speed]", "0.5");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.speed === 0.5);
    await page.click("[aria-controls=panel]");
  });

  it("knows the scene's own values after a reload, and for who comes later", async () => {
    await page.click("[aria-controls=panel]");
    await page.fill("[aria-label='Mass damping in 1/s']", "2");
    await page.keyboard.press("Enter");
    await page.fill("[aria-label^='Gravity along x']", "1");
    await page.keyboard.press("Enter");
    const carried = () =>
      page.waitForFunction(() => location.hash.includes("damping=2,0") && location.hash.includes("gravity=1,"));
    await carried();
    const { settings, simulation } = await state(page);
    expect([settings!.damping.mass, simulation!.gravity[0]]).toEqual([2, 1]);
    for (const again of [() => page.reload(), () => page.goto("about:blank").then(() => page.goto(server.url))]) {
      await again();
      await shown(page);
      await carried(); // also by a page whose address did not say so
      if (!(await page.isVisible("#panel"))) await page.click("[aria-controls=panel]");
      expect(await page.isVisible("[aria-label='Reset mass damping']")).toBe(true);
      expect(await page.isVisible("[aria-label='Reset gravity']")).toBe(true);
    }
    await page.click("[aria-label='Reset mass damping']");
    await page.click("[aria-label='Reset gravity']");
    await page.waitForFunction(() => {
      const { settings: now, simulation: moment } = window.tetfront!.state();
      return now?.damping.mass === 0 && moment?.gravity[0] === 0;
    });
    await page.waitForFunction(() => !/damping|gravity/.test(location.hash));
    expect(await page.isVisible("[aria-label='Reset mass damping']")).toBe(false);
    await page.click("[aria-controls=panel]");
  });

  it("has had no errors and asked nobody but its server", () => expect(problems).toEqual([]));
});
