// Someone puts forces on the object that stay, and pins what shall not move. The object without them is the control.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { difference, largestMove, launch, middle, open, pointOnObject, positions, screenshot, state } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];
let at: { x: number; y: number };
interface Force {
  force: number;
  value: number[];
  triangle: number;
  barycentric: number[];
}
const forces = () => server.simulation.forces as Force[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  server.simulation.gravity = [0, 0, 0]; // no sway: what moves, is pushed
  ({ page, problems } = await open(browser, server.url));
  at = await pointOnObject(page);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const drag = async (from: { x: number; y: number }, dx: number, dy: number) => {
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + dx / 2, from.y + dy / 2, { steps: 3 });
  await page.mouse.move(from.x + dx, from.y + dy, { steps: 3 });
  await page.waitForTimeout(300);
  await page.mouse.up();
};

describe("a force that stays", () => {
  it("is made by a Shift-drag, says its newtons and goes on when the hand is away", async () => {
    const rest = await positions(page);
    await page.waitForTimeout(400);
    expect(largestMove(rest, await positions(page))).toBeLessThan(1e-4);
    await page.keyboard.down("Shift");
    await drag(at, -80, 0);
    await page.keyboard.up("Shift");
    await page.waitForFunction(() => window.tetfront!.state().settings?.forces.length === 1);
    await page.waitForTimeout(800);
    const [force] = forces();
    expect(largestMove(rest, await positions(page))).toBeGreaterThan(0.02);
    expect(await page.innerText("output.force:not([hidden])")).toMatch(/^[\d.]+ k?N$/);
    expect(force.value[0] ** 2 + force.value[1] ** 2).toBeGreaterThan(force.value[2] ** 2); // sideways as the hand
    expect((await state(page)).selectedForce).toBe(force.force);
    await screenshot(page, "force");
  });

  it("is changed by its arrow's head, and neither pulls nor orbits meanwhile", async () => {
    const before = Math.hypot(...forces()[0].value);
    const pulls = () =>
      server.simulation.commands.filter(({ command }: { command: string }) => command === "pull_begin").length;
    await drag({ x: at.x - 80, y: at.y }, -60, 0);
    expect(Math.hypot(...forces()[0].value)).toBeGreaterThan(1.3 * before);
    expect(forces().length).toBe(1);
    expect(pulls()).toBe(0);
  });

  it("is moved by its arrow's foot, and stays as large", async () => {
    const [before] = forces();
    const place = ({ triangle, barycentric }: typeof before) =>
      server.simulation.at(server.simulation.shape.rest, { triangle, barycentric }) as number[];
    // Somewhere between where it was put and where the object has been pushed to.
    let foot = at;
    for (let way = 0; way < 70; way += 4) {
      foot = { x: at.x - way, y: at.y };
      await page.mouse.move(foot.x, foot.y);
      if (/over-arrow/.test((await page.getAttribute("#view", "class")) ?? "")) break;
    }
    await drag(foot, 0, 40);
    const [after] = forces();
    expect(after.value).toEqual(before.value);
    expect(place(after)[2]).toBeLessThan(place(before)[2] - 0.05);
    expect(forces().length).toBe(1);
  });

  it("is typed in newtons", async () => {
    await page.click("[aria-controls=panel]");
    await page.fill("[aria-label='Force 1 in newtons']", "1000");
    await page.keyboard.press("Enter");
    await page.waitForFunction(
      () => Math.abs(Math.hypot(...window.tetfront!.state().settings!.forces[0].value) - 1000) < 1,
    );
    await page.fill("[aria-label='Force 1 along z in newtons']", "-250");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.state().settings!.forces[0].value[2] === -250);
    await page.waitForFunction(
      () => document.querySelector<HTMLInputElement>("[aria-label='Force 1 along z in newtons']")!.value === "-250",
    );
    await screenshot(page, "force_typed");
    await page.click("[aria-controls=panel]");
  });

  it("is removed by Delete, and the object goes back", async () => {
    const pushed = await positions(page);
    await page.keyboard.press("Delete");
    await page.waitForFunction(() => window.tetfront!.state().settings?.forces.length === 0);
    await page.waitForTimeout(800);
    expect(largestMove(pushed, await positions(page))).toBeGreaterThan(0.005);
    expect(await page.isVisible("output.force")).toBe(false);
  });

  it("is made by a key where the pointer is, and in the middle without one", async () => {
    await page.mouse.move(at.x, at.y);
    await page.keyboard.press("n");
    await page.waitForFunction(() => window.tetfront!.state().settings?.forces.length === 1);
    expect(forces()[0].value[0]).toBeGreaterThan(0);
    await page.mouse.move(20, 20); // on the page's title
    await page.keyboard.press("n");
    await page.waitForFunction(() => window.tetfront!.state().settings?.forces.length === 2);
    await page.click("[aria-controls=panel]");
    await page.click("[aria-label='Remove force 1']");
    await page.click("[aria-label='Remove force 2']");
    await page.waitForFunction(() => window.tetfront!.state().settings?.forces.length === 0);
    await page.click("[aria-controls=panel]");
  });
});

describe("a force of the scene", () => {
  it("is an arrow with its newtons for as long as it acts, and is nobody's to select", async () => {
    expect(await page.isVisible("output.force")).toBe(false);
    const bare = await middle(page);
    server.simulation.sceneForces = [{ at: [0.2, -0.46, 0.5], value: [-3e3, 0, 4e3] }];
    await page.waitForSelector("output.force:not([hidden])");
    expect(await page.innerText("output.force:not([hidden])")).toBe("5 kN");
    expect(difference(bare, await middle(page, "force_of_scene"))).toBeGreaterThan(0.002);
    server.simulation.sceneForces = [];
    await page.waitForSelector("output.force:not([hidden])", { state: "detached" });
    expect((await state(page)).settings?.forces).toEqual([]);
  });
});

describe("a pin", () => {
  it("holds what is under the pointer, and lets it go again", async () => {
    await page.mouse.move(at.x, at.y);
    await page.keyboard.press("p");
    await page.waitForFunction(() => window.tetfront!.state().settings?.pins.length === 1);
    expect((await state(page)).settings!.pins[0]).toMatchObject({ pinned: true });
    await screenshot(page, "pin");
    await page.keyboard.press("p");
    await page.waitForFunction(() => window.tetfront!.state().settings?.pins.length === 2);
    expect((await state(page)).settings!.pins[1]).toMatchObject({ pinned: false });
    await page.mouse.move(60, 110); // beside the object nothing is pinned
    await page.keyboard.press("p");
    await page.waitForTimeout(200);
    expect((await state(page)).settings!.pins.length).toBe(2);
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
