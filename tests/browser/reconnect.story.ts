// The server is killed and started again; before that, it builds its model. The page says what is going on and comes back.

import type { Browser } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { largestMove, launch, open, positions, screenshot, shown, state } from "./support";

let browser: Browser;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser.close());

describe("the connection", () => {
  it("is found again after a restart, with a countdown in between", async () => {
    let server = await startMockServer();
    const { page } = await open(browser, server.url);
    await page.keyboard.press("c");
    const colouring = (await state(page)).colouring;
    await server.close();
    await page.waitForSelector(".banner .countdown");
    expect(await page.innerText(".banners")).toMatch(/No connection to the server. Trying again in \d+ s/);
    expect(await page.innerText(".pill")).toBe("offline");
    expect(await page.isDisabled("[aria-label=Reset]")).toBe(true);
    expect((await positions(page)).length).toBeGreaterThan(0); // the last picture stays
    await screenshot(page, "offline");

    await page.keyboard.press("r"); // nothing is sent later by surprise
    expect(await page.innerText(".toasts")).toContain("Reset: there is no connection");

    server = await startMockServer({ port: server.port });
    await page.waitForFunction(
      () => window.tetfront!.state().link.status === "open" && window.tetfront!.state().simulation,
    );
    await page.waitForSelector(".banner", { state: "detached" });
    // It moves again; how much in what time depends on the machine.
    const before = await positions(page);
    let moved = 0;
    for (let i = 0; i < 20 && moved <= 0.005; ++i) {
      await page.waitForTimeout(250);
      moved = Math.max(moved, largestMove(before, await positions(page)));
    }
    expect(moved).toBeGreaterThan(0.005);
    expect((await state(page)).colouring).toBe(colouring);
    expect(server.simulation.commands).toEqual([]);
    await page.close();
    await server.close();
  });

  it("waits for the new server's word before it sends anything, and shows the last picture meanwhile", async () => {
    let server = await startMockServer({ detail: 3 });
    const { page } = await open(browser, server.url);
    await page.keyboard.press("d"); // a pull is held
    await page.waitForFunction(() => window.tetfront!.state().pullsByKeys);
    await server.close();
    await page.waitForFunction(() => window.tetfront!.state().link.status === "waiting");
    expect((await state(page)).pullsByKeys).toBe(false);
    server = await startMockServer({ detail: 3, port: server.port, building: 6000 });
    await page.waitForFunction(() => window.tetfront!.state().link.status === "open");
    expect(await page.innerText(".pill")).toBe("building");
    expect(await page.isDisabled("[aria-label=Reset]")).toBe(true);
    await page.keyboard.press("d");
    await page.keyboard.press("r");
    expect(await page.innerText(".toasts")).toContain("Reset: the server is not ready yet");
    expect((await state(page)).pullsByKeys).toBe(false);
    expect((await positions(page)).length).toBeGreaterThan(0);
    await page.waitForFunction(() => window.tetfront!.state().simulation);
    expect(await page.innerText(".pill")).toBe("live");
    expect(server.simulation.commands).toEqual([]);
    await page.close();
    await server.close();
  });

  it("is given up when nothing comes any more, and found again", async () => {
    const server = await startMockServer({ detail: 3 });
    const { page } = await open(browser, server.url);
    expect(await page.innerText(".pill")).toBe("live");
    const [viewer] = server.simulation.viewers;
    server.simulation.viewers.clear(); // nothing is sent or heard, and nothing is closed
    await page.waitForFunction(() => window.tetfront!.state().link.status === "waiting");
    expect(await page.innerText(".pill")).toBe("offline");
    await page.waitForFunction(() => window.tetfront!.state().simulation);
    expect(server.simulation.viewers.size).toBe(1);
    expect(server.simulation.viewers.has(viewer)).toBe(false);
    await page.close();
    await server.close();
  });

  it("is tried at once when the browser says that there is a network again", async () => {
    let server = await startMockServer({ detail: 3 });
    const { page } = await open(browser, server.url);
    await server.close();
    await page.waitForFunction(() => {
      const { link } = window.tetfront!.state();
      return link.status === "waiting" && link.attempt >= 4; // 4 s
    });
    server = await startMockServer({ detail: 3, port: server.port });
    await page.evaluate(() => window.dispatchEvent(new Event("online")));
    await page.waitForFunction(() => window.tetfront!.state().simulation, undefined, { timeout: 3000 });
    await page.close();
    await server.close();
  });

  it("shows how far the model is", async () => {
    const server = await startMockServer({ building: 12_000 });
    const page = await browser.newPage({ viewport: { width: 640, height: 360 } });
    await page.goto(server.url);
    await page.waitForSelector("progress");
    await page.waitForSelector("progress[value]");
    expect(await page.innerText(".banners")).toMatch(/Building the model: elasticity matrices \([1-9]\d %\)/);
    await screenshot(page, "building");
    await shown(page);
    expect(await page.$("progress")).toBeNull();
    await page.close();
    await server.close();
  });

  it("tells a warning of the simulation for as long as it holds", async () => {
    const server = await startMockServer();
    const { page } = await open(browser, server.url);
    server.simulation.warning = "The solver stopped early.";
    await page.waitForSelector(".banner.warning");
    expect(await page.innerText(".banner.warning")).toBe("The solver stopped early.");
    server.simulation.warning = "";
    await page.waitForSelector(".banner.warning", { state: "detached" });
    await page.close();
    await server.close();
  });
});
