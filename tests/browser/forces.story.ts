// Someone puts forces on the object that stay, and pins what shall not move. The object without them is the control.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import {
  difference,
  largestMove,
  launch,
  middle,
  open,
  pointOnObject,
  positions,
  screenshot,
  state,
  still,
} from "./support";

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

describe("a force of the scene of a simulation that has not begun", () => {
  it("is where the server says from the beginning", async () => {
    const paused = await startMockServer({ detail: 3, playing: false });
    paused.simulation.sceneForces = [{ at: [0.2, -0.46, 0.5], value: [-3e3, 0, 4e3] }];
    const { page: other } = await open(browser, paused.url);
    const label = async () => other.locator("output.force:not([hidden])").boundingBox();
    await other.waitForSelector("output.force:not([hidden])");
    await still(other);
    const before = (await label())!;
    await screenshot(other, "force_of_scene_paused");
    paused.simulation.tell(paused.simulation.state()); // the same again, when the picture is complete
    await other.waitForTimeout(500);
    const after = (await label())!;
    expect(Math.hypot(after.x - before.x, after.y - before.y)).toBeLessThan(1);
    await other.close();
    await paused.close();
  });
});

describe("a pin", () => {
  const pins = async () => (await state(page)).settings!.pins;
  const pinned = (on: boolean) =>
    page.waitForFunction((wanted) => {
      const all = window.tetfront!.state().settings!.pins;
      return all.length === 1 && all[0].pinned === wanted;
    }, on);

  it("holds what is under the pointer against a force, and lets it go as a whole", async () => {
    const bare = await middle(page);
    await page.mouse.move(at.x, at.y);
    await page.keyboard.press("p");
    await pinned(true);
    await page.waitForTimeout(500); // it plays, so the page is never still
    expect(difference(bare, await middle(page, "pin"))).toBeGreaterThan(0.0005); // its dot
    const [pin] = await pins();
    const held = (all: number[]) => {
      const { shape } = server.simulation;
      const place = server.simulation.at(shape.rest, pin) as number[];
      return all.filter((_, i) => {
        const v = i - (i % 3);
        return Math.hypot(...place.map((x, k) => (shape.rest[v + k] as number) - x)) < 0.9 * pin.radius;
      });
    };
    const before = await positions(page);
    server.simulation.forces = [
      { force: 0, triangle: pin.triangle, barycentric: pin.barycentric, value: [-4e3, 0, 0] },
    ];
    await page.waitForTimeout(800);
    const after = await positions(page);
    expect(held(before).length).toBeGreaterThan(2);
    expect(largestMove(before, after)).toBeGreaterThan(0.01);
    expect(largestMove(held(before), held(after))).toBeLessThan(1e-3);
    server.simulation.forces = [];
    await page.waitForTimeout(1500);
    await page.mouse.move(at.x + 3, at.y + 2); // not exactly there
    await page.keyboard.press("p");
    await pinned(false);
    const [free] = await pins();
    expect(free).toEqual({ ...pin, pinned: false }); // no crescent of it stays
    await page.waitForTimeout(500);
    await page.mouse.move(at.x, at.y);
    await page.waitForTimeout(500);
    expect(difference(bare, await middle(page, "unpinned"))).toBeLessThan(0.0005);
    expect(await page.locator("#panel").textContent()).toContain("P pins what is under the pointer");
    await page.mouse.move(60, 110); // beside the object nothing is pinned
    await page.keyboard.press("p");
    await page.waitForTimeout(200);
    expect((await pins()).length).toBe(1);
  });

  it("has had no errors", () => expect(problems).toEqual([]));
});
