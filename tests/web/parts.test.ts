import { describe, expect, it } from "vitest";

import type { Command, Settings, StiffnessPart, Vec3 } from "../../web/src/messages";
import { clearParts, effective, FACTORS, isSame, partAt, regionRadius, setPart, snapped } from "../../web/src/parts";
import { foresee, stepPart, stepped, without } from "../../web/src/parts";
import { PartEdits } from "../../web/src/part_edits";
import { initialState, Store } from "../../web/src/store";
import { random } from "./bytes";

/** A part of a line: triangle i is at i metres. */
const part = (triangle: number, value: number, radius = 1): StiffnessPart => ({
  ...{ triangle, value, radius, barycentric: [1, 0, 0] },
});
/** What server/PROTOCOL.md says of stiffness_scale with a place. */
const obey = (parts: readonly StiffnessPart[], commands: readonly Command[]): StiffnessPart[] =>
  commands.reduce<StiffnessPart[]>(
    (now, command) => {
      if (command.command !== "stiffness_scale" || !("radius" in command)) throw new Error("another command");
      const { value, triangle, barycentric, radius } = command;
      const said = { value, triangle, barycentric, radius };
      const all = [...now.filter((other) => !isSame(other, said)), said];
      const first = all.findIndex((other) => other.value !== 1);
      return first < 0 ? [] : all.slice(first);
    },
    [...parts],
  );
/** Factors of the line's first metres: the last word on a place counts. */
const factors = (parts: readonly StiffnessPart[]): number[] =>
  Array.from(
    { length: 8 },
    (_, x) => parts.findLast(({ triangle, radius }) => Math.abs(triangle - x) <= radius)?.value ?? 1,
  );

describe("factors", () => {
  it("go up and down through the same numbers and stop at the ends", () => {
    for (let i = 1; i < FACTORS.length; ++i) {
      expect(stepped(FACTORS[i - 1], 1)).toBe(FACTORS[i]);
      expect(stepped(FACTORS[i], -1)).toBe(FACTORS[i - 1]);
    }
    expect([stepped(100, 1), stepped(0.01, -1), stepped(3, 1), stepped(3, -1)]).toEqual([100, 0.01, 5, 2]);
  });
});

describe("setting a part", () => {
  const three = [part(2, 5, 2), part(3, 0.1), part(4, 10, 2)];

  it("is one command for the last one, and for a new one", () => {
    expect(setPart(three, three[2], 20)).toEqual([{ command: "stiffness_scale", ...part(4, 20, 2) }]);
    expect(setPart(three, part(6, 1), 2)).toEqual([{ command: "stiffness_scale", ...part(6, 2) }]);
    expect(setPart([], part(6, 1), 2).length).toBe(1);
  });

  it("keeps one that lies below others below them", () => {
    const after = obey(three, setPart(three, three[1], 0.5));
    expect(after).toEqual([three[0], part(3, 0.5), three[2]]);
  });

  it("to 1 takes it away, and shows again what it hid", () => {
    const after = obey(three, setPart(three, three[2], 1));
    expect(effective(after)).toEqual(three.slice(0, 2));
    expect(factors(after)).toEqual([5, 5, 0.1, 0.1, 0.1, 1, 1, 1]);
    // The last word alone would have hidden them.
    expect(factors([...three.slice(0, 2), part(4, 1, 2)])).toEqual([5, 5, 1, 1, 1, 1, 1, 1]);
  });

  it("changes that part alone, whatever came before", () => {
    const next = random(7);
    let told: StiffnessPart[] = []; // the server's
    let wanted: StiffnessPart[] = []; // as if parts could be changed in place and removed
    for (let i = 0; i < 2000; ++i) {
      const target = part(next() % 8, 1, 1 + (next() % 3));
      const value = FACTORS[next() % FACTORS.length];
      const isKnown = wanted.some((p) => isSame(p, target));
      if (value === 1 && !isKnown) continue;
      const commands = setPart(told, target, value);
      const foreseen = foresee(told, commands);
      told = obey(told, commands);
      expect(foreseen).toEqual(told);
      if (value === 1) wanted = wanted.filter((p) => !isSame(p, target));
      else if (isKnown) wanted = wanted.map((p) => (isSame(p, target) ? { ...p, value } : p));
      else wanted = [...wanted, { ...target, value }];
      expect(told).toEqual(wanted); // what was taken away fills no list
      expect(factors(told)).toEqual(factors(wanted));
    }
    expect(obey(told, clearParts(told))).toEqual([]);
    expect(clearParts(told).length).toBe(wanted.length);
  });
});

describe("what a hand means", () => {
  const away = (x: number) => (other: StiffnessPart) => Math.abs(other.triangle - x);
  const at = (x: number, radius: number, ...parts: StiffnessPart[]) =>
    partAt(parts, { triangle: x, barycentric: [0, 1, 0] }, radius, away(x));

  it("is the part that it has made there, the last one of several", () => {
    expect(at(3, 2, part(2, 5, 2))).toEqual(part(2, 5, 2));
    expect(at(3, 2, part(2, 5, 2), part(3, 7, 2), part(4, 3, 9))).toEqual(part(3, 7, 2));
  });
  it("is a new one elsewhere, and for another size, as stiff as the place is", () => {
    const fresh = { triangle: 3, barycentric: [0, 1, 0], radius: 2 };
    expect(at(3, 2)).toEqual({ ...fresh, value: 1 });
    expect(at(3, 2, part(6, 5, 2))).toEqual({ ...fresh, value: 1 });
    expect(at(3, 2, part(1, 5, 2))).toEqual({ ...fresh, value: 5 });
    expect(at(3, 2, part(3, 5, 9), part(3, 7, 4))).toEqual({ ...fresh, value: 7 });
  });
  it("uses a place again that is without effect, and minds what is below it", () => {
    expect(at(3, 2, part(3, 1, 2), part(4, 5, 9))).toEqual(part(3, 5, 2));
    expect(at(3, 2, part(3, 5, 2), part(2, 1, 2))).toEqual(part(3, 5, 2));
  });
  it("is stiffer or softer by a step, and never the other way by what lies below", () => {
    const press = (parts: StiffnessPart[], direction: 1 | -1) => {
      const meant = at(3, 2, ...parts);
      return obey(parts, stepPart(parts, meant, without(parts, meant, away(3)), direction));
    };
    const stiffness = (parts: StiffnessPart[]) => factors(parts)[3];
    const through = (parts: StiffnessPart[], direction: 1 | -1) =>
      Array.from({ length: 6 }, () => stiffness((parts = press(parts, direction))));
    expect(through([], 1)).toEqual([2, 5, 10, 20, 50, 100]);
    expect(through([part(3, 5, 2)], -1)).toEqual([2, 1, 0.5, 0.2, 0.1, 0.05]);
    expect(through([part(3, 5, 9)], -1)).toEqual([2, 0.5, 0.2, 0.1, 0.05, 0.02]);
    expect(through([part(3, 0.2, 9)], 1)).toEqual([0.5, 2, 5, 10, 20, 50]);
  });
});

describe("edits", () => {
  it("count before the server has told of them, and no longer when it does not", () => {
    let now = 0;
    const store = new Store({ ...initialState });
    const tell = (stiffness_parts: StiffnessPart[]) =>
      store.set({ settings: { stiffness_parts } as unknown as Settings });
    const sent: Command[] = [];
    const edits = new PartEdits(
      store,
      (command) => sent.push(command),
      () => now,
    );
    const values = () => sent.splice(0).map((command) => "value" in command && command.value);
    tell([]);
    for (let i = 0; i < 3; ++i) edits.step(edits.parts.find((p) => isSame(p, part(3, 1))) ?? part(3, 1), 1, 1);
    expect(values()).toEqual([2, 5, 10]);
    tell([part(3, 2)]); // it has come to the first
    expect(edits.parts).toEqual([part(3, 10)]);
    now = 1001;
    expect(edits.parts).toEqual([part(3, 2)]);

    // Two that are removed at once do not come back with what is said again.
    tell([part(1, 2), part(2, 5), part(3, 10)]);
    edits.set(part(1, 2), 1);
    edits.set(part(2, 5), 1);
    expect(values()).toEqual([1, 5, 10, 1, 10]);
    expect(effective(edits.parts)).toEqual([part(3, 10)]);
    edits.clear();
    expect(values()).toEqual([1]);
    edits.forget();
    expect(edits.parts.length).toBe(3);
  });
});

describe("a place", () => {
  it("survives a server that divides by its sum, to the bit", () => {
    const next = random(3);
    const share = () => next() / 2 ** 32;
    for (let i = 0; i < 5000; ++i) {
      const [u, v] = [share(), share()];
      const hit: Vec3 = i % 9 ? [Math.max(0, 1 - u * v - (1 - u) * v), u * v, (1 - u) * v] : [0, u, 1 - u];
      const place = snapped(hit);
      expect(place[0] + place[1] + place[2]).toBe(1);
      expect(place[2] + place[1] + place[0]).toBe(1);
      for (let k = 0; k < 3; ++k) {
        expect(place[k]).toBeGreaterThanOrEqual(0);
        expect(Math.abs(place[k] - hit[k])).toBeLessThan(3e-6);
      }
    }
  });
  it("has a radius in percent of the object's diagonal", () => {
    expect(regionRadius({ rest_box: [0, 0, 0, 1, 2, 2] }, 7.5)).toBeCloseTo(0.225, 12);
    expect(regionRadius({ rest_box: [1, 1, 1, 1, 1, 1] }, 7.5)).toBeGreaterThan(0);
  });
});
