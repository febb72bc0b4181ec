// The object cut open shows the front's tets on the cut: each in its level's colour, in the light that falls on the cut.
//
// The light is measured: by stiffness the cut is one grey, so that pixel over grey is the light there. What the tets show
// must be a level's colour in the same light; their polygons turn either way, and must not be lit from behind.

import type { Browser } from "playwright-core";
import { afterAll, beforeAll, describe, expect, it } from "vitest";

import { levelColour } from "../../web/src/palette";
import { startMockServer } from "./mock_server.mjs";
import { launch, middle, open, state, still } from "./support";
import type { Pixels } from "./support";

let browser: Browser;
let server: Awaited<ReturnType<typeof startMockServer>>;
beforeAll(async () => {
  browser = await launch();
  server = await startMockServer({ playing: false });
});
afterAll(async () => {
  await browser.close();
  await server.close();
});

type Colour = readonly [number, number, number]; // 0..255, sRGB
const CAP: Colour = [0x8d, 0x8a, 0x84]; // of the plain cut in the dark theme: web/src/viewer/section.ts
const LEVELS = [0, 1, 2].map((level) => levelColour(level).map((x) => 255 * x) as unknown as Colour);

const linear = (x: number): number => (x <= 10.3 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4);
const at = ({ data }: Pixels, i: number): Colour => [data[4 * i], data[4 * i + 1], data[4 * i + 2]];
const isCap = (colour: Colour): boolean =>
  Math.min(...colour) > 60 && Math.max(...colour) - Math.min(...colour) < 0.12 * Math.max(...colour);
const isGround = (colour: Colour): boolean => Math.max(...colour) < 60;

/** The level whose colour this is in the light that makes `cap` of the grey; -1: none. */
function levelOf(colour: Colour, cap: Colour): number {
  const off = LEVELS.map((level) =>
    Math.max(
      ...[0, 1, 2].map((c) => {
        const wanted = (linear(cap[c]) / linear(CAP[c])) * linear(level[c]);
        return Math.abs(linear(colour[c]) - wanted) / (0.05 + wanted);
      }),
    ),
  );
  const best = off.indexOf(Math.min(...off));
  return off[best] < 0.08 ? best : -1;
}

describe.each([
  { cut: "x,0.45", camera: "1.6,-2.9,1.5,0,0,0.48", levels: [0, 1] },
  { cut: "z,0.6", camera: "0.5,-1.2,2.9,0,0,0.48", levels: [0] },
])("a cut at $cut", ({ cut, camera, levels }) => {
  it("shows the front's tets by level, evenly lit, and nothing of them beside it", async () => {
    const { page, problems } = await open(browser, server.url, {
      width: 1000,
      height: 700,
      dark: true,
      fragment: `scene=mock&cut=${cut}&camera=${camera}`,
    });
    expect((await state(page)).cut).not.toBeNull();
    await still(page);
    const tets = await middle(page, `cut_tets_${cut[0]}`);
    await page.keyboard.press("c");
    await still(page);
    const plain = await middle(page, `cut_plain_${cut[0]}`);

    const found = new Map<number, number>();
    let [onCut, ground, changed] = [0, 0, 0];
    for (let i = 0; i < plain.data.length / 4; ++i) {
      const before = at(plain, i);
      const now = at(tets, i);
      if (isCap(before)) {
        ++onCut;
        const level = levelOf(now, before);
        found.set(level, (found.get(level) ?? 0) + 1);
      } else if (isGround(before)) {
        ++ground;
        if (before.some((x, c) => Math.abs(x - now[c]) > 3)) ++changed;
      }
    }
    expect(onCut).toBeGreaterThan(2000);
    expect(ground).toBeGreaterThan(2000);
    // The rest are the tets' rims.
    expect(found.get(-1) ?? 0).toBeLessThan(0.35 * onCut);
    for (const level of [0, 1, 2])
      if (levels.includes(level)) expect(found.get(level) ?? 0).toBeGreaterThan(0.05 * onCut);
      else expect(found.get(level) ?? 0).toBe(0);
    expect(changed).toBe(0);
    expect(problems).toEqual([]);
    await page.close();
  });
});
