// Cards are translucent: their text has to be read over whatever picture lies below. The worst are white and black.

import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";

type Colour = readonly [red: number, green: number, blue: number, alpha: number]; // 0..255, alpha 0..1

const sheet = readFileSync(new URL("../../web/src/styles/base.css", import.meta.url), "utf8");
const [light, dark] = [/^:root \{(.*?)^\}/ms, /^:root\[data-theme="dark"\] \{(.*?)^\}/ms].map(
  (block) =>
    new Map([...block.exec(sheet)![1].matchAll(/(--[\w-]+): ([^;]+);/g)].map(([, name, value]) => [name, value])),
);

function parse(css: string): Colour {
  const hex = /^#(\w{3}|\w{6})$/.exec(css)?.[1];
  const digits = hex?.length === 3 ? hex.replace(/./g, "$&$&") : hex;
  if (digits) return [...[0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16)), 1] as unknown as Colour;
  const numbers = /^rgb\((\d+) (\d+) (\d+) \/ (\d+)%\)$/.exec(css);
  if (!numbers) throw new Error(`${css} is not a colour that this test knows`);
  const [red, green, blue, percent] = numbers.slice(1).map(Number);
  return [red, green, blue, percent / 100];
}

const over = ([r, g, b, a]: Colour, below: Colour): Colour =>
  [...[r, g, b].map((x, i) => a * x + (1 - a) * below[i]), 1] as unknown as Colour;

/** As in WCAG 2. */
function contrast(a: Colour, b: Colour): number {
  const linear = (x: number) => (x <= 10.3 ? x / 255 / 12.92 : ((x / 255 + 0.055) / 1.055) ** 2.4);
  const [low, high] = [a, b]
    .map(([red, green, blue]) => 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue))
    .sort((x, y) => x - y);
  return (high + 0.05) / (low + 0.05);
}

describe.each([
  ["light", light],
  ["dark", new Map([...light, ...dark])],
] as const)("text on a card, %s", (_, variables) => {
  const colour = (name: string) => parse(variables.get(name)!);
  const pictures: Colour[] = [
    [0, 0, 0, 1],
    [255, 255, 255, 1],
  ];
  it.each([
    ["--text", ["--well", "--hover"]],
    ["--soft", ["--well"]],
    ["--accent", []],
    ["--warn", ["--well"]],
    ["--bad", []],
  ])("%s is read over any picture", (text, surfaces) => {
    for (const picture of pictures) {
      const card = over(colour("--card"), picture);
      for (const surface of [card, ...surfaces.map((name) => over(colour(name), card))])
        expect(contrast(colour(text), surface)).toBeGreaterThanOrEqual(4.5);
    }
  });

  it("--on-accent is read on --accent", () =>
    expect(contrast(colour("--on-accent"), colour("--accent"))).toBeGreaterThanOrEqual(4.5));
});
