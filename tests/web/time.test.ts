import { describe, expect, it } from "vitest";

import type { SimulationState } from "../../web/src/messages";
import { decodeBinary } from "../../web/src/protocol";
import type { Frame, Topology } from "../../web/src/protocol";
import { makeScale, RangeFollower, readableCeiling } from "../../web/src/scale";
import { Series, stack } from "../../web/src/series";
import { History, SECONDS } from "../../web/src/viewer/history";
import { frame, topology } from "./bytes";

const frameAt = (time: number, generation = 1) => decodeBinary(frame(1, { time, generation })) as Frame;
const front = decodeBinary(topology(1)) as Topology;

describe("History", () => {
  const filled = (count: number) => {
    const history = new History();
    for (let i = 0; i < count; ++i) history.push(frameAt(i / 10), front, 100 * i);
    return history;
  };

  it("finds the last moment that is not after a time", () => {
    const history = filled(50);
    expect(history.range).toEqual([0, 4.9]);
    expect(history.at(2.04)?.frame.time).toBeCloseTo(2);
    expect(history.at(2.1)?.frame.time).toBeCloseTo(2.1);
    expect(history.at(-1)?.frame.time).toBe(0);
    expect(history.at(99)?.frame.time).toBeCloseTo(4.9);
    expect(new History().at(0)).toBeNull();
  });

  it("keeps the last seconds only", () => {
    const history = filled(10 * SECONDS + 100);
    expect(history.length).toBeLessThanOrEqual(10 * SECONDS + 1);
    expect(history.range[1] - history.range[0]).toBeCloseTo(SECONDS, 0);
  });

  it("starts over with a reset and with another model", () => {
    const history = filled(20);
    history.push(frameAt(0), front, 3000);
    expect(history.length).toBe(1);
    history.push(frameAt(1, 2), front, 3100);
    expect(history.length).toBe(1);
  });

  it("keeps no more bytes than it may, and counts a topology once for all moments that have it", () => {
    const bytes = frame(1).byteLength;
    const large = (): Topology => ({ ...front, edges: new Uint32Array(2500) }); // 10 kB
    const history = new History(25_000 + 5 * bytes);
    const [first, second, third] = [large(), large(), large()];
    [first, first, first, second].forEach((topology, i) => history.push(frameAt(i), topology, i));
    expect(history.times).toEqual([0, 1, 2, 3]);
    history.push(frameAt(4), third, 4); // room for two of them: the oldest goes when its last moment has gone
    expect(history.times).toEqual([3, 4]);
    history.push(frameAt(4), third, 5); // the same moment again
    history.push(frameAt(5), third, 6);
    history.push(frameAt(6), third, 7);
    expect(history.times).toEqual([3, 4, 5, 6]);
    history.push(frameAt(0), first, 8); // a reset
    history.push(frameAt(1), second, 9);
    expect(history.times).toEqual([0, 1]);
  });

  it("keeps the newer of two frames of one moment", () => {
    const history = filled(3);
    const again = frameAt(0.2);
    history.push(again, front, 900);
    expect(history.length).toBe(3);
    expect(history.at(9)?.frame).toBe(again);
  });
});

describe("Series", () => {
  const state = (time: number, patch: Partial<SimulationState> = {}) =>
    ({ time, tets_by_level: [10, 20], milliseconds: 3, estimate: 0.02, tolerance: 0.05, ...patch }) as SimulationState;

  it("has a column for each level and phase, and a place for what is not known", () => {
    const series = new Series();
    series.push(state(0));
    series.push(
      state(0.1, {
        phases: { adapt: 1, setup: 2, assemble: 3, solve: 4, other: 5 },
        energy: { kinetic: 6, elastic: 7 },
      }),
    );
    expect(series.levels).toEqual([
      [10, 10],
      [20, 20],
    ]);
    expect(series.phases.map((column) => column[0])).toEqual([0, 0, 0, 0, 3]);
    expect(series.phases.map((column) => column[1])).toEqual([1, 2, 3, 4, 5]);
    expect(series.elastic).toEqual([null, 7]);
    expect(series.estimate[1]).toBeCloseTo(2);
  });

  it("forgets what is old, what was before a reset, and states that say nothing new", () => {
    const series = new Series();
    for (let i = 0; i < 500; ++i) expect(series.push(state(i / 10))).toBe(true);
    expect(series.push(state(49.9))).toBe(false);
    expect(series.time[0]).toBeCloseTo(29.9);
    expect(new Set([series.time, ...series.levels, series.kinetic].map((column) => column.length)).size).toBe(1);
    series.push(state(0));
    expect(series.time).toEqual([0]);
  });

  it("stacks", () => {
    expect(stack([[1, 2], [10, 20], [0, 5]])).toEqual([[1, 2], [11, 22], [11, 27]]); // prettier-ignore
    expect(stack([])).toEqual([]);
  });
});

describe("scales of fields", () => {
  it.each([
    [0, 0],
    [-1, 0],
    [0.9, 1],
    [1, 1],
    [1.01, 1.5],
    [6.5e4, 8e4],
    [8.1, 10],
    [0.0031, 0.004],
  ])("end at a readable number not below %d: %d", (x, ceiling) => expect(readableCeiling(x)).toBeCloseTo(ceiling, 12));

  it("go up at once and down only after a while", () => {
    const follower = new RangeFollower();
    const at = (typical: number, now: number) => follower.follow({ field: "stress", typical }, now);
    expect(at(900, 0)).toBe(1000);
    expect(at(3900, 100)).toBe(4000);
    expect(at(900, 200)).toBe(4000);
    expect(at(3900, 1500)).toBe(4000); // back before the time was over
    expect(at(900, 1700)).toBe(4000);
    expect(at(900, 3300)).toBe(1000);
    expect(follower.follow({ field: "strain", typical: 0.09 }, 3400)).toBeCloseTo(0.1);
  });

  it("say what a colour means, in its unit", () => {
    expect(makeScale("stress", [0, 2.5e5]).label(2.5e5)).toBe("250 kPa");
    expect(makeScale("displacement", [0, 0.02]).label(0.02)).toBe("2 cm");
    expect(makeScale("strain", [0, 0.5]).position(0.25)).toBe(0.5);
  });
});
