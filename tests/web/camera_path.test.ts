import { describe, expect, it } from "vitest";

import { CameraPath } from "../../web/src/camera_path";
import type { Vec3 } from "../../web/src/messages";

const origin: Vec3 = [0, 0, 0];
const eye = (x: number): Vec3 => [x, 0, 0];

describe("the camera's path during a recording", () => {
  it("is nothing while the camera stands still, and of another recording", () => {
    const path = new CameraPath();
    for (let i = 0; i < 9; ++i) path.sample("a", i, eye(1), origin);
    expect(path.keyframes("a")).toEqual([]);
    path.sample("a", 9, eye(2), origin);
    expect(path.keyframes("a").length).toBeGreaterThan(1);
    expect(path.keyframes("b")).toEqual([]);
    path.sample("b", 10, eye(3), origin);
    expect([path.keyframes("a"), path.keyframes("b")]).toEqual([[], []]);
  });

  it("stands still up to the moment at which it began to move", () => {
    const path = new CameraPath();
    for (let i = 0; i <= 5; ++i) path.sample("a", i, eye(1), origin);
    path.sample("a", 6, eye(2), origin);
    expect(path.keyframes("a").map(({ time, eye: [x] }) => [time, x])).toEqual([
      [0, 1],
      [5, 1],
      [6, 2],
    ]);
  });

  it("stays short and in order however long it is, from the first moment on", () => {
    const path = new CameraPath();
    for (let i = 0; i < 10_000; ++i) path.sample("a", i / 30, eye(i), origin);
    const times = path.keyframes("a").map(({ time }) => time);
    expect(times.length).toBeGreaterThan(12);
    expect(times.length).toBeLessThanOrEqual(24);
    expect(times[0]).toBe(0);
    expect(times.at(-1)).toBeGreaterThan(280);
    expect(times).toEqual([...times].sort((a, b) => a - b));
  });
});
