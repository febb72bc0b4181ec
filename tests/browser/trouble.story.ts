// Something is not as it should be: a token is wanted, the simulation has failed, the line or the page is too slow. The page
// says so, and says what helps.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { difference, launch, middle, open, positions, screenshot, shown, state, still } from "./support";

let browser: Browser;
beforeAll(async () => {
  browser = await launch();
});
afterAll(() => browser.close());

describe("a server with a token", () => {
  it("lets in who knows it, and remembers it", async () => {
    const server = await startMockServer({ token: "correct-horse-battery" });
    const context = await browser.newContext({ viewport: { width: 640, height: 360 } });
    const page = await context.newPage();
    await page.goto(`${server.url}?quality=low`);
    const field = page.locator("[aria-label='Access token']");
    await field.waitFor();
    expect(await page.innerText(".pill")).toBe("locked");
    await screenshot(page, "token");
    await field.fill("wrong-wrong-wrong-wrong");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => document.querySelector(".banners")?.textContent?.includes("not the token"));
    expect(server.simulation.viewers.size).toBe(0);
    await field.fill("correct-horse-battery");
    await page.keyboard.press("Enter");
    await shown(page);
    expect(await field.count()).toBe(0);
    // It is a cookie that scripts cannot read, and no part of the address.
    expect(page.url()).not.toContain("horse");
    expect(await page.evaluate(() => document.cookie)).toBe("");
    await page.reload();
    await shown(page);
    await context.close();
    await server.close();
  });
});

describe("a simulation that has failed", () => {
  it("says so, keeps its last picture, and starts again by one click", async () => {
    const server = await startMockServer({ detail: 3 });
    const { page, problems } = await open(browser, server.url);
    server.simulation.fail();
    await page.waitForSelector(".banner.warning");
    expect(await page.innerText(".banner.warning span")).toBe(server.simulation.warning);
    expect(await page.innerText(".pill")).toBe("paused");
    await still(page);
    expect((await positions(page)).length).toBeGreaterThan(0);
    await screenshot(page, "failed");
    await page.click(".banner.warning button");
    await page.waitForSelector(".banner.warning", { state: "detached" });
    expect(server.simulation.commands.at(-1)).toMatchObject({ command: "reset" });
    expect((await state(page)).simulation?.time).toBe(0);
    expect(problems).toEqual([]);
    await page.close();
    await server.close();
  });
});

describe("frames that do not arrive", () => {
  it("are counted: those that the server dropped, and those that this page was too slow for", async () => {
    const server = await startMockServer({ detail: 3 });
    server.simulation.lacks = ["acknowledge"]; // or it would send no more than the page takes
    const { page, problems } = await open(browser, server.url, { width: 1000 });
    const numbers = "[aria-label=Numbers]";
    expect(await page.innerText(numbers)).not.toContain("Slow connection");
    const link = { type: "link", sent: 100, dropped: 0, unacknowledged: 2, round_trip: 0.02 };
    server.simulation.tell(link);
    server.simulation.tell({ ...link, sent: 110, dropped: 40, round_trip: 0.31 });
    await page.waitForFunction(() => window.tetfront!.state().linkReport?.dropped === 40);
    expect(await page.innerText(numbers)).toContain(
      "Slow connection or page: 10 of 50 frames arrive, 310 ms there and back",
    );
    await screenshot(page, "slow_link");
    server.simulation.tell({ ...link, sent: 140, dropped: 40 });
    await page.waitForFunction(() => window.tetfront!.state().linkReport?.sent === 140);
    expect(await page.innerText(numbers)).not.toContain("Slow connection");

    const before = (await state(page)).framesDropped;
    await page.evaluate(() => {
      const end = performance.now() + 600;
      while (performance.now() < end); // the page's thread is busy with something else
    });
    await page.waitForFunction((n) => window.tetfront!.state().framesDropped > n, before);
    expect(await page.innerText(numbers)).toMatch(/\d+ frames skipped: this page draws more slowly than they come/);
    expect(problems).toEqual([]);
    await page.close();
    await server.close();
  });
});

describe("a page that draws nothing, as one that nobody sees", () => {
  it("keeps neither the server nor the line busy, and sees the present when it wakes up", async () => {
    const server = await startMockServer({ detail: 3 });
    const { page, problems } = await open(browser, server.url);
    const [viewer] = server.simulation.viewers as Set<{ acknowledged: number; flying: number[] }>;
    await expect.poll(() => viewer.acknowledged).toBeGreaterThan(5);
    await page.evaluate(() => {
      const draw = window.requestAnimationFrame.bind(window);
      const held: FrameRequestCallback[] = [];
      window.requestAnimationFrame = (turn) => held.push(turn);
      Object.assign(window, {
        wake: () => {
          window.requestAnimationFrame = draw;
          held.forEach((turn) => draw(turn));
        },
      });
    });
    await page.waitForTimeout(500);
    const { acknowledged } = viewer;
    const { framesDropped } = await state(page);
    await page.waitForTimeout(700);
    expect(viewer.acknowledged).toBe(acknowledged);
    expect(viewer.flying.length).toBe(2);
    expect((await state(page)).framesDropped).toBe(framesDropped);
    await page.evaluate(() => (window as unknown as { wake: () => void }).wake());
    const { sequence } = server.simulation;
    await expect.poll(() => viewer.acknowledged).toBeGreaterThan(sequence);
    expect(problems).toEqual([]);
    await page.close();
    await server.close();
  });
});

describe("a picture whose graphics processor is taken away", () => {
  it("says so, and is drawn again when it comes back", async () => {
    const server = await startMockServer({ detail: 3, playing: false });
    const { page } = await open(browser, server.url);
    await still(page);
    const before = await middle(page);
    await page.evaluate(() => {
      const context = document.querySelector<HTMLCanvasElement>("#view")!.getContext("webgl2")!;
      Object.assign(window, { loser: context.getExtension("WEBGL_lose_context")! });
      (window as unknown as { loser: WEBGL_lose_context }).loser.loseContext();
    });
    await page.waitForSelector(".toast");
    expect(await page.innerText(".toasts")).toContain("The picture was lost");
    const redraws = await page.evaluate(() => window.tetfront!.redraws());
    await page.evaluate(() => (window as unknown as { loser: WEBGL_lose_context }).loser.restoreContext());
    await page.waitForFunction((n) => window.tetfront!.redraws() > n, redraws);
    await page.click("[aria-label=Dismiss]"); // it lies over the picture
    await still(page);
    expect(difference(before, await middle(page, "context_restored"))).toBeLessThan(0.01);
    await page.close();
    await server.close();
  });
});

describe("a server that has too many clients", () => {
  it("turns the page away and says why; the page comes back by itself", async () => {
    const server = await startMockServer({ detail: 3, most: 1 });
    const { page: first } = await open(browser, server.url);
    const second = await browser.newPage({ viewport: { width: 640, height: 360 } });
    await second.goto(`${server.url}?quality=low`);
    await second.waitForSelector(".banner .countdown");
    expect(await second.innerText(".banners")).toMatch(/The server says: there are too many clients. Trying again in/);
    await screenshot(second, "too_many");
    await first.close();
    await shown(second);
    await second.close();
    await server.close();
  });
});

describe("a page that cannot begin", () => {
  const fatal = async (prepare: (page: Page) => Promise<void>) => {
    const server = await startMockServer({ detail: 3 });
    const page = await browser.newPage({ viewport: { width: 640, height: 360 } });
    await prepare(page);
    await page.goto(server.url);
    await page.waitForSelector("#fatal:not([hidden])");
    const text = await page.innerText("#fatal");
    await screenshot(page, "fatal");
    await page.close();
    await server.close();
    return text;
  };

  it("says that a part of it is missing", async () => {
    const text = await fatal((page) => page.route("**/assets/main-*.js", (route) => route.fulfill({ status: 404 })));
    expect(text).toMatch(/did not load\s+Reload it/);
  });

  it("says that the connection's script is missing", async () => {
    const text = await fatal((page) => page.route("**/assets/worker-*.js", (route) => route.fulfill({ status: 404 })));
    expect(text).toMatch(/did not load\s+Reload it.*script of the connection/s);
  });

  it("says that the browser has no WebGL 2", async () => {
    const text = await fatal((page) =>
      page.addInitScript(() => Object.assign(HTMLCanvasElement.prototype, { getContext: () => null })),
    );
    expect(text).toMatch(/cannot show the picture.*WebGL 2/s);
  });
});
