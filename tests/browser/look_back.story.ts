// Someone looks back: the past has the colours that were kept with it, the legend says which, and the picture is of that moment.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { difference, launch, middle, open, state, still } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  ({ page, problems } = await open(browser, server.url));
  await page.waitForFunction(() => (window.tetfront!.frame()?.time ?? 0) > 1.5);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const legend = async () => (await page.innerText(".legend")).replace(/\s+/g, " ");
const colouring = async (wanted: string) => {
  while ((await state(page)).colouring !== wanted) await page.keyboard.press("c");
};
const lookAt = async (time: number) => {
  // As a hand does: the browser takes no value that is written otherwise than it writes it.
  await page.evaluate((value) => {
    const slider = document.querySelector<HTMLInputElement>("[aria-label=Time]")!;
    slider.value = String(value);
    slider.dispatchEvent(new Event("input"));
  }, time);
  await page.waitForFunction((at) => Math.abs((window.tetfront!.state().scrub ?? -1) - at) < 0.1, time);
  await still(page);
};

describe("the past", () => {
  it("is shown by level where nobody asked for values, and the legend says so", async () => {
    await colouring("stress");
    await page.waitForFunction(() => document.querySelector(".legend")!.textContent!.includes("Von Mises"));
    await page.waitForTimeout(700);
    await page.keyboard.press("Space");
    await page.waitForFunction(() => window.tetfront!.state().simulation?.playing === false);
    const live = (await state(page)).simulation!.time;
    await lookAt((await page.evaluate(() => window.tetfront!.times()[0])) + 0.1);
    expect(await legend()).toMatch(/^Level of refinement .*Kept without values/);
    const without = await middle(page, "past_without_values");
    await colouring("level");
    await still(page);
    expect(await legend()).not.toContain("values");
    expect(difference(without, await middle(page))).toBe(0);

    await colouring("strain"); // of which nothing has come at all
    expect(await legend()).toContain("Kept without values");
    await colouring("stress");
    await lookAt(live - 0.3);
    expect(await legend()).toMatch(/^Von Mises stress/);
    expect(difference(without, await middle(page, "past_with_values"))).toBeGreaterThan(0.2);
  });

  it("is drawn by the page, as the server knows the present only", async () => {
    const [picture] = await Promise.all([page.waitForEvent("download"), page.keyboard.press("s")]);
    const { hello, scrub } = await state(page);
    const shown = await page.evaluate(() => window.tetfront!.frame()!.time);
    expect(Math.abs(shown - scrub!)).toBeLessThan(0.1);
    expect(picture.suggestedFilename()).toBe(`${hello!.scene.name}-${shown.toFixed(2)}s.png`);
    expect(await page.innerText(".toasts")).toContain("Drawn by this page");
  });

  it("ends with a reset, whoever asked for it", async () => {
    expect((await state(page)).scrub).not.toBeNull();
    server.simulation.command(null, { command: "reset" });
    await page.waitForFunction(() => window.tetfront!.state().scrub === null);
    await page.waitForFunction(() => window.tetfront!.frame()!.time === 0);
    expect(await page.evaluate(() => window.tetfront!.moments())).toBe(1);
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});

describe("colours of a recording", () => {
  it("are those that were recorded, and the others are not offered", async () => {
    const played = await startMockServer({ detail: 3 });
    played.simulation.recorded = { frames: 90, start: 0, end: 3, colouring: "stress" };
    const { page: other } = await open(browser, played.url, { fragment: "scene=mock&colour=strain" });
    const now = async () => (await state(other)).colouring;
    const seen = [await now()];
    for (let i = 0; i < 3; ++i) {
      await other.keyboard.press("c");
      seen.push(await now());
    }
    expect(seen).toEqual(["level", "stiffness", "stress", "level"]);
    await other.click("[aria-controls=panel]");
    const offered = other.locator("[aria-label=Colouring] label:visible");
    expect(await offered.allInnerTexts()).toEqual(["Level", "Stiffness", "Stress"]);
    await other.close();
    await played.close();
  });

  it("are levels again when the server refuses the others", async () => {
    const old = await startMockServer({ detail: 3 });
    const { page: other } = await open(browser, old.url);
    old.simulation.refusals = { colouring: "was not recorded" };
    await other.keyboard.press("c");
    await other.keyboard.press("c");
    await other.waitForFunction(() => window.tetfront!.state().colouring === "level");
    expect(await other.innerText(".toasts")).toContain("Colouring: was not recorded");
    await other.close();
    await old.close();
  });
});
