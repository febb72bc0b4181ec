// Someone makes a part of the object stiffer, another one softer: by keys, by taps, by typing. Elsewhere nothing changes.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { launch, open, pause, pointOnObject, screenshot, state, still } from "./support";
import { PNG } from "pngjs";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];
let at: { x: number; y: number };
interface Part {
  value: number;
  triangle: number;
  barycentric: number[];
  radius: number;
}
const sent = (): Part[] =>
  server.simulation.commands.filter(({ command }: { command: string }) => command === "stiffness_scale");
const parts = () => server.simulation.stiffnessParts as Part[];
/** Where the mock has it, at rest. */
const place = (part: Part) => server.simulation.at(server.simulation.shape.rest, part) as number[];
const panel = () => page.click("[aria-controls=panel]");
const told = (values: number[]) =>
  page.waitForFunction(
    (wanted) =>
      window
        .tetfront!.state()
        .settings!.stiffness_parts!.map(({ value }) => value)
        .join() === wanted.join(),
    values,
  );

/** The object, free of panels. */
const clip = { x: 200, y: 70, width: 240, height: 225 };
const picture = () => page.screenshot({ clip });
/** Pixels that differ, where they are [px] from a point of the page. */
async function changes(before: Buffer, point: { x: number; y: number }) {
  const [a, b] = [before, await picture()].map((png) => PNG.sync.read(png));
  const around = { x: point.x - clip.x, y: point.y - clip.y };
  const changed: { x: number; y: number }[] = [];
  for (let y = 0; y < a.height; ++y)
    for (let x = 0; x < a.width; ++x) {
      const i = 4 * (y * a.width + x);
      if ([0, 1, 2].some((c) => Math.abs(a.data[i + c] - b.data[i + c]) > 8))
        changed.push({ x: x - around.x, y: y - around.y });
    }
  return changed;
}

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 4 });
  server.simulation.gravity = [0, 0, 0];
  ({ page, problems } = await open(browser, server.url));
  await pause(page);
  at = await pointOnObject(page);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

describe("a part of the object", () => {
  it("becomes stiffer by K where the pointer is, which its rim shows, there and nowhere else", async () => {
    const before = await picture();
    await page.keyboard.press("k");
    await told([2]);
    await still(page);
    await screenshot(page, "part");
    const { value, radius, barycentric } = sent()[0];
    expect(value).toBe(2);
    expect(radius).toBeCloseTo(0.075 * Math.sqrt(3), 9);
    expect(barycentric.reduce((a, b) => a + b)).toBe(1);
    expect(await page.innerText("output.part:not([hidden])")).toBe("1: ×2");
    const changed = await changes(before, at);
    expect(changed.filter(({ x, y }) => Math.hypot(x, y) > 60)).toEqual([]);
    // Below the middle is the rim alone, not the tag.
    expect(changed.filter(({ x, y }) => y > 8 && Math.hypot(x, y) > 12).length).toBeGreaterThan(50);
  });

  it("is the same one for the next press, and for Shift K, which brings it back", async () => {
    await page.keyboard.press("k");
    await told([5]);
    await page.keyboard.press("Shift+K");
    await page.keyboard.press("Shift+K");
    await told([]);
    expect(new Set(sent().map(({ triangle }) => triangle)).size).toBe(1);
    await page.waitForSelector("output.part:not([hidden])", { state: "detached" });
    await page.keyboard.press("Shift+K");
    await told([0.5]);
    expect(parts().length).toBe(1);
  });

  it("is not made beside the object", async () => {
    const before = sent().length;
    await page.mouse.move(60, 110);
    await page.keyboard.press("k");
    await page.waitForSelector(".toast");
    expect(await page.innerText(".toasts")).toMatch(/not under the pointer/);
    expect(sent().length).toBe(before);
    await page.click("[aria-label=Dismiss]");
  });

  it("has the size that [ and ] show for a moment", async () => {
    await page.mouse.move(at.x, at.y - 60);
    await still(page);
    const before = await picture();
    await page.keyboard.press("]");
    await page.keyboard.press("]");
    await page.waitForTimeout(300);
    await screenshot(page, "part_preview");
    expect((await changes(before, { x: at.x, y: at.y - 60 })).length).toBeGreaterThan(100);
    await page.waitForTimeout(1800);
    await still(page);
    expect((await changes(before, at)).length).toBe(0);
    await page.keyboard.press("k");
    await told([0.5, 2]);
    expect(parts()[1].radius / parts()[0].radius).toBeCloseTo(1.25 ** 2, 2);
    expect(place(parts()[1])[2]).toBeGreaterThan(place(parts()[0])[2] + 0.05);
  });

  it("is typed in the panel, without a change of the others", async () => {
    await panel();
    await page.fill('[aria-label="Part 1, times the scene\'s stiffness"]', "0.3");
    await page.keyboard.press("Enter");
    await told([0.3, 2]);
    await screenshot(page, "part_typed");
    await page.$eval("[aria-label^='Part 1']", (input) => input.removeAttribute("max"));
    await page.fill("[aria-label^='Part 1']", "");
    await page.keyboard.press("Enter");
    await page.waitForFunction(
      () => document.querySelector<HTMLInputElement>("[aria-label^='Part 1']")!.value === "0.3",
    );
    await panel();
  });

  it("is the same for every viewer", async () => {
    const { page: other } = await open(browser, server.url);
    await other.waitForFunction(() => window.tetfront!.state().settings?.stiffness_parts?.length === 2);
    await other.click("[aria-controls=panel]");
    expect(await other.locator(".parts li").count()).toBe(2);
    await other.locator("[aria-label='Remove part 1']").press("Enter");
    await other.waitForFunction(() => document.querySelectorAll(".parts li").length === 1);
    await other.waitForFunction(() => document.activeElement?.getAttribute("aria-label") === "Remove part 1");
    await other.close();
    await told([2]);
    expect(await page.locator(".parts li").count()).toBe(1);
  });

  it("is made by a tap while a tool is in the hand, which neither pulls nor orbits", async () => {
    const camera = () => page.evaluate(() => location.hash);
    const pulls = () =>
      server.simulation.commands.filter(({ command }: Part & { command: string }) => /pull/.test(command));
    await panel();
    await page.click("button.tool:text('Softer')");
    expect(await page.getAttribute("button.tool:text('Softer')", "aria-pressed")).toBe("true");
    expect(await page.isVisible("#panel")).toBe(false); // it lies over the picture here
    expect(await page.innerText(".banners")).toMatch(/softer/);
    const drag = async () => {
      await page.mouse.move(at.x, at.y);
      await page.mouse.down();
      await page.mouse.move(at.x + 50, at.y, { steps: 4 });
      await page.mouse.up();
      await page.waitForTimeout(200);
    };
    const before = await camera();
    await page.mouse.click(at.x + 30, at.y + 30);
    await told([2, 0.5]);
    await drag();
    expect(parts().length).toBe(2);
    expect(pulls().length).toBe(0);
    await screenshot(page, "part_tool");
    await page.keyboard.press("Escape");
    await page.waitForTimeout(600); // the address is written late
    expect(await camera()).toBe(before);
    expect((await state(page)).tool).toBeNull();
    await drag();
    expect(pulls().length).toBeGreaterThan(0);
  });

  it("says when the server refuses it", async () => {
    const before = parts();
    server.simulation.stiffnessParts = Array.from({ length: 64 }, (_, i) => ({
      ...before[0],
      radius: 10 + i,
      value: 3,
    }));
    server.simulation.tell(server.simulation.settings());
    await page.mouse.move(at.x, at.y);
    await page.keyboard.press("k");
    await page.waitForSelector(".toast");
    expect(await page.innerText(".toasts")).toMatch(/Stiffness: parts have 64/);
    server.simulation.stiffnessParts = before;
    server.simulation.tell(server.simulation.settings());
  });

  it("goes with all others", async () => {
    await panel();
    await page.click("text=Remove all");
    await told([]);
    expect(await page.locator(".parts li").count()).toBe(0);
    expect(await page.isVisible("text=Remove all")).toBe(false);
    await panel();
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
