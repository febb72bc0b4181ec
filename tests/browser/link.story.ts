// Links: pasted into a page that is open already, for another scene than the one that is served, and what they say of the camera and the cut.

import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { startMockServer } from "./mock_server.mjs";
import { launch, open, screenshot, state } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
let page: Page;
let problems: string[];

beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ detail: 3, playing: false });
  server.simulation.cut = { point: [0, 0, 0], normal: [1, 0, 0] };
  ({ page, problems } = await open(browser, server.url));
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

const hash = () => page.evaluate(() => location.hash);
const paste = (fragment: string) => page.evaluate((text) => (location.hash = text), fragment);
const settle = () => page.waitForTimeout(900);

describe("a link", () => {
  it("says nothing of the cut that the scene itself has, but that it was closed", async () => {
    expect((await state(page)).cut).toEqual({ axis: 0, at: 0.5, flip: false });
    await settle();
    expect(await hash()).toBe("");
    await screenshot(page, "cut_of_scene");
    await page.keyboard.press("x");
    await page.waitForFunction(() => location.hash.includes("cut=none"));
    await page.keyboard.press("x");
    await page.waitForFunction(() => location.hash === "");
  });

  it("says where keys have moved the camera, also while nothing else happens", async () => {
    await page.keyboard.press("Shift+ArrowLeft");
    await page.waitForFunction(() => location.hash.includes("camera="));
    await page.keyboard.press("f");
    await page.waitForFunction(() => !location.hash.includes("camera="));
  });

  it("that is pasted into an open page is taken over", async () => {
    await page.keyboard.press("w");
    await page.waitForFunction(() => location.hash.includes("wire=1"));
    await paste("scene=mock&colour=stiffness&tolerance=0.01&camera=3,-3,2,0,0,0.5");
    await page.waitForFunction(() => window.tetfront!.state().simulation?.tolerance === 0.01);
    expect(await state(page)).toMatchObject({ colouring: "stiffness", wireframe: false });
    await settle();
    expect(await hash()).toBe("#scene=mock&colour=stiffness&camera=3,-3,2,0,0,0.5&tolerance=0.01");
    await paste("");
    await settle();
    expect(await state(page)).toMatchObject({ colouring: "level" });
    expect(await hash()).toBe("#scene=mock&tolerance=0.01"); // as it is, for all viewers
  });

  it("for another scene waits for it, and acts on nothing", async () => {
    const link = "scene=coarse&colour=stiffness&tolerance=0.02&gravity=1,0,0";
    await paste(link);
    await page.waitForSelector(".toast");
    expect(await page.innerText(".toasts")).toContain("This link is for the scene coarse; open it with O");
    await settle();
    expect(await hash()).toBe(`#${link}`);
    expect(await state(page)).toMatchObject({ colouring: "level", simulation: { tolerance: 0.01 } });
    server.simulation.load({ name: "coarse", title: "A coarser ball (mock)", detail: 3 });
    await page.waitForFunction(() => window.tetfront!.state().simulation?.gravity[0] === 1);
    expect(await state(page)).toMatchObject({ colouring: "stiffness", simulation: { tolerance: 0.02 } });
  });

  it("for another scene gives way to what the user does", async () => {
    await paste("scene=nowhere&colour=strain");
    await page.waitForFunction(() => document.querySelector(".toasts")!.textContent!.includes("nowhere"));
    await settle();
    expect(await hash()).toBe("#scene=nowhere&colour=strain");
    await page.keyboard.press("w");
    await page.waitForFunction(() => location.hash.startsWith("#scene=coarse") && location.hash.includes("wire=1"));
    expect((await state(page)).colouring).toBe("stiffness");
  });

  it("has made no errors", () => expect(problems).toEqual([]));
});
