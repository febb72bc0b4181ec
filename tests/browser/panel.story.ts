// Someone uses the controls beside the picture, with the mouse and with the keyboard: they send, show what is so, and give keys back.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { count, percent } from "../../web/src/format";
import { startMockServer } from "./mock_server.mjs";
import { launch, open, pause, screenshot, state } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];
const sent = (name: string) =>
  server.simulation.commands.filter(({ command }: { command: string }) => command === name);
const refuse = (...commands: string[]) =>
  (server.simulation.refusals = Object.fromEntries(commands.map((command) => [command, "not now"])));
const focused = () => page.evaluate(() => document.activeElement?.getAttribute("aria-label"));
const enter = async (label: string, value: string) => {
  await page.fill(`[aria-label='${label}']`, value);
  await page.keyboard.press("Enter");
};
const becomes = (label: string, value: string) =>
  page.waitForFunction(
    ([name, wanted]) => document.querySelector<HTMLInputElement>(`[aria-label='${name}']`)!.value === wanted,
    [label, value] as const,
  );
const settingsAre = (wanted: object) =>
  page.waitForFunction((text) => {
    const now = window.tetfront!.state().settings as unknown as Record<string, unknown>;
    return Object.entries(JSON.parse(text) as object).every(([k, v]) => JSON.stringify(now[k]) === JSON.stringify(v));
  }, JSON.stringify(wanted));

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3 });
  ({ page, problems } = await open(browser, server.url, { width: 1000, height: 760 }));
  await pause(page);
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

describe("keys", () => {
  const wireframe = async () => (await state(page)).wireframe;
  it("are shortcuts again after a slider, a switch or a choice was used with the mouse", async () => {
    for (const control of ["[aria-label='Tolerance, slider']", "text=Wireframe of", "text=Linear"]) {
      await page.click(control);
      const before = await wireframe();
      await page.keyboard.press("w");
      expect(await wireframe(), control).toBe(!before);
    }
    // Also after a list was opened, and closed without a choice.
    const speed = (await page.locator("[aria-label=Speed]").boundingBox())!;
    await page.mouse.click(speed.x + speed.width / 2, speed.y + speed.height / 2);
    await page.keyboard.press("Escape"); // closes the list
    const before = await wireframe();
    await page.keyboard.press("w");
    expect(await wireframe()).toBe(!before);
    await page.mouse.click(speed.x + speed.width / 2, speed.y + speed.height / 2);
    await page.keyboard.press("ArrowDown");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.speed === 2);
    await page.keyboard.press("w");
    expect(await wireframe()).toBe(before);
    await page.click("[aria-label='Reset speed']");
  });

  it("are a slider's where it has the focus by keyboard, and only those that it knows", async () => {
    const { step } = (await state(page)).simulation!;
    const before = await wireframe();
    await page.focus("[aria-label='Region, slider']");
    const { regionSize } = await state(page);
    await page.keyboard.press("ArrowRight");
    await page.keyboard.press("w");
    expect((await state(page)).regionSize).toBeGreaterThan(regionSize);
    expect(await wireframe()).toBe(!before);
    expect((await state(page)).simulation!.step).toBe(step);
  });

  it("choose in a list that has the focus by keyboard", async () => {
    const before = await wireframe();
    await page.focus("[aria-label='Tet budget in tets']");
    await page.focus("[aria-label='Coarsest level']");
    await page.keyboard.press("ArrowDown");
    await page.keyboard.press("w");
    await settingsAre({ levels: { min: 1, max: 2 } });
    expect(await wireframe()).toBe(before);
    await page.click("[aria-label='Reset levels']");
    await settingsAre({ levels: { min: 0, max: 2 } });
  });

  it("fold a group by Space, and play nothing", async () => {
    const plays = sent("play").length;
    await page.focus("summary:text('Physics')");
    await page.keyboard.press("Space");
    expect(await page.isVisible("[aria-label='Mass damping in 1/s']")).toBe(false);
    await page.keyboard.press("Space");
    expect(await page.isVisible("[aria-label='Mass damping in 1/s']")).toBe(true);
    expect(sent("play").length).toBe(plays);
  });
});

describe("controls", () => {
  it("send budget and damping, and reset them", async () => {
    await enter("Tet budget in tets", "5000");
    await settingsAre({ budget: { tets: 5000, milliseconds: null } });
    await enter("Time budget in ms/step", "12");
    await settingsAre({ budget: { tets: 5000, milliseconds: 12 } });
    await page.click("[aria-label='Reset tet budget']");
    await page.click("[aria-label='Reset time budget']");
    await settingsAre({ budget: { tets: null, milliseconds: null } });
    await enter("Mass damping in 1/s", "2");
    await enter("Stiffness damping in s", "0.01");
    await settingsAre({ damping: { mass: 2, stiffness: 0.01 } });
    await page.click("[aria-label='Reset mass damping']");
    await page.click("[aria-label='Reset stiffness damping']");
    await settingsAre({ damping: { mass: 0, stiffness: 0 } });
    expect(await page.isVisible("[aria-label='Reset mass damping']")).toBe(false);
  });

  it("reset order and speed", async () => {
    await page.click("text=Quadratic");
    await settingsAre({ order: 2 });
    await page.click("[aria-label='Reset order']");
    await settingsAre({ order: 1 });
    expect(await page.isVisible("[aria-label='Reset order']")).toBe(false);
    await page.selectOption("[aria-label=Speed]", "0.25");
    await screenshot(page, "panel_speed");
    await page.click("[aria-label='Reset speed']");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.speed === 1);
    expect(await page.isVisible("[aria-label='Reset speed']")).toBe(false);
  });

  it("take how far tets are apart and where the cut is as numbers, and reset them", async () => {
    await page.keyboard.press("e");
    await page.keyboard.press("x");
    await enter("Explode in percent", "40");
    await enter("Place of the cut in percent", "62.5");
    expect(await state(page)).toMatchObject({ explode: 0.4, cut: { at: 0.625 } });
    await page.$eval("summary", (element) => element.scrollIntoView());
    await screenshot(page, "panel_view");
    const slider = page.locator("[aria-label='Place of the cut, slider']");
    await slider.press("ArrowDown");
    await slider.press("ArrowDown");
    expect((await state(page)).cut!.at).toBeLessThan(0.615);
    await page.click("[aria-label='Reset explode']");
    await page.click("[aria-label='Reset place of the cut']");
    expect(await state(page)).toMatchObject({ explode: 0, cut: { at: 0.5 } });
    await page.keyboard.press("e");
    await page.keyboard.press("x");
  });

  it("go back to what is so when the server refuses", async () => {
    await page.click("[aria-label='Reset tolerance']");
    await becomes("Tolerance in percent", "5");
    refuse("tolerance", "budget", "order", "levels", "gravity", "damping", "speed");
    await enter("Tolerance in percent", "2");
    await becomes("Tolerance in percent", "5");
    await enter("Tet budget in tets", "7");
    await becomes("Tet budget in tets", "");
    await enter("Mass damping in 1/s", "3");
    await becomes("Mass damping in 1/s", "0");
    await enter("Gravity along z in metres per second squared", "1");
    await becomes("Gravity along z in metres per second squared", "-9.81");
    await page.selectOption("[aria-label='Coarsest level']", "2");
    await becomes("Coarsest level", "0");
    await page.selectOption("[aria-label=Speed]", "2");
    await becomes("Speed", "1");
    await page.click("text=Quadratic");
    await page.waitForSelector(".toast:has-text('Order: not now')");
    expect(await page.isChecked("[name^=Order][value='1']")).toBe(true);
    expect(sent("order").at(-1)).toMatchObject({ value: 2 });
    refuse();
  });
});

describe("the list of forces", () => {
  const row = (force: number) => ({ force, triangle: 40 * force, barycentric: [0.5, 0.25, 0.25], value: [300, 0, 0] });
  const told = (...forces: ReturnType<typeof row>[]) => {
    server.simulation.forces = forces;
    server.simulation.tell(server.simulation.settings());
  };
  it("gives back newtons that a force cannot have, or that were refused", async () => {
    told(row(0), row(1));
    await page.waitForSelector("[aria-label='Force 2 in newtons']");
    for (const impossible of ["0", "-5"]) {
      await enter("Force 1 in newtons", impossible);
      await becomes("Force 1 in newtons", "300");
    }
    refuse("force_move");
    await enter("Force 1 along y in newtons", "40");
    await becomes("Force 1 along y in newtons", "0");
    expect(sent("force_move").length).toBe(1);
    refuse();
  });

  it("shows what others do while it has the focus, but leaves what is being typed", async () => {
    await page.fill("[aria-label='Force 2 along y in newtons']", "12");
    told({ ...row(1), value: [0, 0, 700] });
    await page.waitForSelector("[aria-label='Force 1 in newtons']", { state: "detached" });
    await becomes("Force 2 in newtons", "700");
    await becomes("Force 2 along y in newtons", "12");
    await page.keyboard.press("Enter");
    await page.waitForFunction(() => window.tetfront!.state().settings!.forces[0].value.join() === "0,12,700");
  });

  it("keeps the focus in the list when a row is removed, and then in its group", async () => {
    told(row(1), row(2), row(3));
    await page.focus("[aria-label='Remove force 3']");
    await page.keyboard.press("Enter");
    await page.waitForSelector("[aria-label='Remove force 3']", { state: "detached" });
    expect(await focused()).toBe("Remove force 4");
    await page.keyboard.press("Enter");
    await page.waitForSelector("[aria-label='Remove force 4']", { state: "detached" });
    expect(await focused()).toBe("Remove force 2");
    await page.keyboard.press("Enter");
    await page.waitForSelector(".loads li", { state: "detached" });
    expect(await page.evaluate(() => document.activeElement?.textContent)).toBe("Forces and pins");
  });
});

describe("plots", () => {
  it("show the present when they are opened, also during a pause", async () => {
    for (let i = 0; i < 3; ++i) await page.keyboard.press("ArrowRight");
    await page.keyboard.press("g");
    const numbers = () => page.$$eval(".plots h2 b", (values) => values.map(({ textContent }) => textContent));
    await page.waitForFunction(() => document.querySelector(".plots h2 b")!.textContent !== "");
    const compare = async () => {
      const s = (await state(page)).simulation!;
      const phases = Object.values(s.phases!).reduce((a, b) => a + b);
      const [tets, step, error, energy] = await numbers();
      expect(tets).toBe(count(s.tets_by_level.reduce((a, b) => a + b)));
      expect(parseFloat(step!)).toBeCloseTo(phases, 1);
      expect(error).toBe(percent(s.estimate));
      expect(parseFloat(energy!)).toBeCloseTo(s.energy!.kinetic + s.energy!.elastic, 2);
    };
    await compare();
    await page.keyboard.press("g");
    const pull = { triangle: 0, barycentric: [1, 0, 0], target: [0, 0, 0.5] };
    server.simulation.pulls.set(-1, pull); // from the next step on there are more tets
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction(() => window.tetfront!.state().simulation!.tets_by_level[2] > 0);
    await page.keyboard.press("g");
    expect((await numbers())[0]).toBe(count(4310));
    await compare();
    server.simulation.pulls.clear();
    await page.keyboard.press("g");
    await page.click("[aria-controls=panel]"); // this window has room for one of the two
  });
});

describe("messages", () => {
  it("are counted anew after one was dismissed", async () => {
    const say = () => server.simulation.tell({ type: "log", level: "info", message: "the disk is full" });
    const toasts = page.locator(".toast:has-text('the disk is full')");
    say();
    await toasts.locator("button").click();
    await page.waitForTimeout(5500);
    say();
    await toasts.waitFor();
    await page.waitForTimeout(2000); // past the end of the first
    say();
    await page.waitForSelector(".toast:has-text('×2')");
    expect(await toasts.count()).toBe(1);
  });

  it("tell of skipped frames for as long as they are skipped", async () => {
    // Of a server that does not wait for acknowledgements.
    const eager = await startMockServer({ detail: 3 });
    const { hello } = eager.simulation;
    eager.simulation.hello = () => ({ ...hello(), capabilities: ["edit"] });
    const { page: other } = await open(browser, eager.url, { width: 1000 });
    const note = other.locator(".status .note:has-text('skipped')");
    await other.evaluate(() => {
      for (const end = performance.now() + 800; performance.now() < end;);
    });
    await note.waitFor();
    eager.simulation.playing = false;
    await note.waitFor({ state: "hidden", timeout: 15_000 });
    await other.close();
    await eager.close();
  });

  it("say that the lists could not be asked for", async () => {
    refuse("scenes", "recordings");
    await page.keyboard.press("o");
    await page.waitForSelector(".cards:has-text('The server did not say.')");
    await page.keyboard.press("Escape");
    await page.click("text=Recordings …");
    await page.waitForSelector(".files:has-text('The server did not say.')");
    await page.keyboard.press("Escape");
    refuse();
    expect(problems).toEqual([]);
  });
});
