// A phone: one finger pulls on the object or orbits beside it; a second one turns a pull into the camera's zoom.

import type { Browser, CDPSession, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import type { Force } from "../../web/src/messages";
import { startMockServer } from "./mock_server.mjs";
import { launch, shown } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let session: CDPSession;
const sent = () => server.simulation.commands.map(({ command }: { command: string }) => command);
const touch = (type: "touchStart" | "touchMove" | "touchEnd", ...points: [number, number][]) =>
  session.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  server.simulation.gravity = [0, 0, 0];
  const context = await browser.newContext({ viewport: { width: 360, height: 640 }, hasTouch: true, isMobile: true });
  page = await context.newPage();
  await page.goto(`${server.url}?quality=low`);
  await shown(page);
  session = await context.newCDPSession(page);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

describe("touch", () => {
  it("orbits beside the object without pulling", async () => {
    const camera = () => page.evaluate(() => location.hash);
    await touch("touchStart", [30, 150]);
    await touch("touchMove", [80, 170]);
    await touch("touchMove", [120, 180]);
    await touch("touchEnd");
    await page.waitForFunction(() => location.hash.includes("camera="));
    expect(await camera()).toContain("camera=");
    expect(sent()).toEqual([]);
  });

  it("pulls with one finger; a second one ends the pull and zooms", async () => {
    await touch("touchStart", [180, 310]);
    await touch("touchMove", [200, 300]);
    await touch("touchMove", [230, 290]);
    await page.waitForFunction(() => (window.tetfront!.frame()?.pulls.length ?? 0) > 0);
    const before = await page.evaluate(() => location.hash);
    await touch("touchStart", [230, 290], [130, 400]);
    await page.waitForFunction(() => window.tetfront!.frame()?.pulls.length === 0);
    await touch("touchMove", [250, 260], [110, 430]);
    await touch("touchMove", [270, 230], [90, 460]);
    await touch("touchEnd");
    await page.waitForFunction((hash) => location.hash !== hash, before);
    expect(sent().filter((command: string) => command === "pull_begin").length).toBe(1);
    expect(sent().at(-1)).toBe("pull_end");
  });

  it("makes a part stiffer by a tap with a tool; a second finger zooms and turns nothing", async () => {
    /** The camera's distance [m] and its direction. */
    const camera = async () => {
      const numbers = /camera=([^&]*)/.exec(decodeURIComponent(await page.evaluate(() => location.hash)));
      const [x, y, z, ...target] = (numbers as RegExpExecArray)[1].split(",").map(Number);
      const away = [x - target[0], y - target[1], z - target[2]];
      const distance = Math.hypot(...away);
      return { distance, direction: away.map((length) => length / distance) };
    };
    const scaled = () => sent().filter((command: string) => command === "stiffness_scale").length;
    await page.reload();
    await shown(page);
    await page.tap("[aria-controls=panel]");
    await page.tap("button.tool:text('Stiffer')");
    const before = sent().length;
    const start = await camera();
    await touch("touchStart", [180, 310]);
    await touch("touchStart", [180, 310], [130, 400]);
    await touch("touchMove", [185, 300], [125, 410]);
    await touch("touchMove", [190, 290], [120, 420]);
    await touch("touchEnd");
    await page.waitForTimeout(1500);
    expect(scaled()).toBe(0);
    const end = await camera();
    expect(end.distance).toBeLessThan(0.9 * start.distance);
    end.direction.forEach((length, axis) => expect(length).toBeCloseTo(start.direction[axis], 2));
    await touch("touchStart", [180, 310]);
    await touch("touchEnd");
    await page.waitForFunction(() => window.tetfront!.state().settings?.stiffness_parts?.length === 1);
    expect(sent().slice(before)).toEqual(["stiffness_scale"]);
    await page.tap(".banner button");
    expect(await page.locator(".banner").count()).toBe(0);
  });

  it("puts a force by a tap with a tool, and drags its arrow", async () => {
    await page.goto(`${server.url}?quality=low`); // the camera at home
    await shown(page);
    await page.tap("[aria-controls=panel]");
    await page.tap("button.tool:text('Force')");
    expect(await page.innerText(".banner")).toMatch(/^Tap where a force acts/);
    const before = sent().length;
    await touch("touchStart", [180, 310]);
    await touch("touchEnd");
    await page.waitForFunction(() => window.tetfront!.state().settings?.forces.length === 1);
    expect(sent().slice(before)).toEqual(["force_add"]);
    expect(await page.locator(".banner").count()).toBe(0);
    const [first] = (await page.evaluate(() => window.tetfront!.state().settings!.forces)) as Force[];
    expect(await page.evaluate(() => window.tetfront!.state().selectedForce)).toBe(first.force);
    await page.waitForTimeout(800); // the object gives way, and its arrow with it
    await page.screenshot({ path: new URL("../../test-results/touch_force.png", import.meta.url).pathname });
    // Where web/src/viewer/bands.ts puts the label of an arrow's head.
    const label = (await page.locator("output.force:not([hidden])").boundingBox())!;
    const head: [number, number] = [label.x - 12, label.y + 26];
    await touch("touchStart", head);
    await touch("touchMove", [head[0], head[1] - 20]);
    await touch("touchMove", [head[0], head[1] - 60]);
    await touch("touchEnd");
    await page.waitForFunction(
      (z) => window.tetfront!.state().settings!.forces[0].value[2] > z,
      first.value[2] + 0.2 * Math.hypot(...first.value),
    );
  });
});
