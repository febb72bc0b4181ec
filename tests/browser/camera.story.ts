// Someone moves the view, by the mouse and by the keyboard alone; and sees the present as a ghost while looking back.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import type { Pin } from "../../web/src/messages";
import { startMockServer } from "./mock_server.mjs";
import { difference, launch, middle, open, pause, pointOnObject, positions, screenshot, state, still } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];
const HOME = [1.6, -2.9, 1.5, 0, 0, 0.48]; // eye, target: tests/browser/mock_simulation.mjs

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  ({ page, problems } = await open(browser, server.url));
  await page.waitForFunction(() => window.tetfront!.moments() > 20);
  await pause(page);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

/** Where the camera is, as the address says it after `act`: its distance [m], its direction, and what it looks at. */
async function cameraAfter(act: () => Promise<void>) {
  await act();
  await page.waitForFunction(() => location.hash.includes("camera="));
  await page.waitForTimeout(700); // the address follows
  const text = /camera=([^&]*)/.exec(decodeURIComponent(await page.evaluate(() => location.hash)))![1];
  const numbers = text.split(",").map(Number);
  const away = [0, 1, 2].map((i) => numbers[i] - numbers[3 + i]);
  const distance = Math.hypot(...away);
  return { distance, direction: away.map((x) => x / distance), target: numbers.slice(3) };
}
const homeAway = [0, 1, 2].map((i) => HOME[i] - HOME[3 + i]);
const homeDistance = Math.hypot(...homeAway);
const homeDirection = homeAway.map((x) => x / homeDistance);
const turned = (direction: number[]) => Math.acos(direction.reduce((sum, x, i) => sum + x * homeDirection[i], 0));
const home = async () => {
  await page.keyboard.press("f");
  await still(page);
};

describe("the mouse", () => {
  it("zooms by its wheel, nearer and farther, in the same direction", async () => {
    const before = await middle(page);
    await page.mouse.move(320, 180);
    const near = await cameraAfter(() => page.mouse.wheel(0, -400));
    expect(near.distance).toBeLessThan(0.95 * homeDistance);
    expect(turned(near.direction)).toBeLessThan(0.01);
    await still(page);
    expect(difference(before, await middle(page))).toBeGreaterThan(0.05);
    const far = await cameraAfter(() => page.mouse.wheel(0, 1200));
    expect(far.distance).toBeGreaterThan(1.05 * near.distance);
    await home();
    expect(difference(before, await middle(page))).toBeLessThan(0.01);
  });

  it("orbits by a right drag on the object, from the same distance around the same point", async () => {
    const at = await pointOnObject(page);
    const { direction, distance, target } = await cameraAfter(async () => {
      await page.mouse.move(at.x, at.y);
      await page.mouse.down({ button: "right" });
      await page.mouse.move(at.x + 60, at.y, { steps: 4 });
      await page.mouse.up({ button: "right" });
    });
    expect(turned(direction)).toBeGreaterThan(0.2);
    expect(distance).toBeCloseTo(homeDistance, 2);
    target.forEach((x, i) => expect(x).toBeCloseTo(HOME[3 + i], 2));
    await home();
  });

  it("looks at the point of a double-click, from nearer", async () => {
    const at = await pointOnObject(page);
    const { direction, distance, target } = await cameraAfter(() => page.mouse.dblclick(at.x, at.y));
    expect(distance).toBeCloseTo(0.6 * homeDistance, 2);
    expect(turned(direction)).toBeLessThan(0.01);
    // On the ball's surface.
    const all = await positions(page);
    const away = [...all.keys()]
      .filter((i) => i % 3 === 0)
      .map((i) => Math.hypot(...[0, 1, 2].map((k) => all[i + k] - target[k])));
    expect(Math.min(...away)).toBeLessThan(0.12);
    expect(Math.hypot(...target.map((x, i) => x - HOME[3 + i]))).toBeGreaterThan(0.3);
    await home();
  });
});

describe("the keyboard alone", () => {
  const pins = () => server.simulation.pins as Pin[];
  const place = (pin: Pin): number[] => server.simulation.at(server.simulation.shape.rest, pin) as number[];
  const crossed = () => page.isVisible(".aim");

  it("aims at a cross in the middle, which a pointer takes away", async () => {
    await page.click("h1");
    expect(await crossed()).toBe(false);
    await page.keyboard.press("Tab");
    await page.focus("#view");
    expect(await crossed()).toBe(true);
    await screenshot(page, "aim");
    await page.mouse.move(320, 180);
    expect(await crossed()).toBe(false);
    await page.mouse.move(20, 20);
    expect(await crossed()).toBe(true);
  });

  it("moves the view, so that another place is pinned", async () => {
    await page.keyboard.press("p");
    await page.waitForFunction(() => window.tetfront!.state().settings?.pins.length === 1);
    for (let i = 0; i < 3; ++i) await page.keyboard.press("6");
    await page.keyboard.press("8");
    await page.keyboard.press("p");
    await page.waitForFunction(() => window.tetfront!.state().settings?.pins.length === 2);
    await screenshot(page, "aim_moved");
    const [first, second] = pins().map(place);
    expect(pins().map(({ pinned }) => pinned)).toEqual([true, true]);
    expect(second[0] - first[0]).toBeGreaterThan(0.1);
    expect(second[2] - first[2]).toBeGreaterThan(0.02);
    for (let i = 0; i < 3; ++i) await page.keyboard.press("4");
    await page.keyboard.press("2");
    await page.keyboard.press("p");
    await page.waitForFunction(() => window.tetfront!.state().settings?.pins.at(-1)?.pinned === false);
    const third = place(pins().at(-1)!);
    expect(Math.hypot(...third.map((x, i) => x - first[i]))).toBeLessThan(0.01);
    for (let i = 0; i < 30; ++i) await page.keyboard.press("4");
    await page.keyboard.press("k");
    await page.waitForSelector(".toast:has-text('not in the middle')");
    server.simulation.pins = [];
    server.simulation.tell(server.simulation.settings());
    await home();
  });
});

describe("looking back", () => {
  it("shows the present as a ghost over the past", async () => {
    const before = (await state(page)).simulation!.step;
    await page.keyboard.press("ArrowRight"); // the page keeps some seconds only: what is shown now may be older
    await page.waitForFunction((step) => window.tetfront!.state().simulation!.step > step, before);
    await still(page);
    const { time } = (await state(page)).simulation!;
    const then = await positions(page);
    const alone = await middle(page);
    // A quarter of a sway farther.
    for (let i = 0; i < 24; ++i) await page.keyboard.press("ArrowRight");
    await page.waitForFunction((t) => window.tetfront!.frame()!.time > t + 0.39, time);
    await still(page);
    await page.$eval(
      ".timeline",
      (slider, moment) => {
        (slider as HTMLInputElement).value = String(moment);
        slider.dispatchEvent(new Event("input"));
      },
      time + 1e-6,
    );
    await page.waitForFunction((t) => Math.abs(window.tetfront!.frame()!.time - t) < 1e-3, time);
    await still(page);
    expect(await positions(page)).toEqual(then);
    expect(difference(alone, await middle(page, "ghost"))).toBeGreaterThan(0.01);
    await page.keyboard.press("l");
    await still(page);
    expect(problems).toEqual([]);
  });
});
