import * as THREE from "three";
import { beforeEach, describe, expect, it, vi } from "vitest";

import type { Command } from "../../web/src/messages";
import { PullHand } from "../../web/src/viewer/pull";

const hit = { triangle: 3, barycentric: [0.25, 0.25, 0.5] as const, point: [1, 2, 3] as const, distance: 1 };
const ray = new THREE.Ray();
const camera = new THREE.PerspectiveCamera();
// Looks along -x with z up: to the right is +y.
camera.up.set(0, 0, 1);
camera.position.set(10, 0, 0);
camera.lookAt(0, 0, 0);

let listeners: Record<string, (event?: object) => void>;
let focused: number;
let sent: Command[];
const events = {
  pick: vi.fn(),
  ray: () => ray,
  send: (command: Command) => sent.push(command),
  enabled: vi.fn(),
  changed: vi.fn(),
  focus: vi.fn(),
  keyed: vi.fn(),
};
let hand: PullHand;
beforeEach(() => {
  vi.resetAllMocks();
  events.pick.mockReturnValue(hit);
  events.enabled.mockReturnValue(true);
  [listeners, focused, sent] = [{}, 0, []];
  const element = {
    addEventListener: (kind: string, listener: () => void) => (listeners[kind] = listener),
    classList: { add: vi.fn(), remove: vi.fn(), toggle: vi.fn() },
    focus: () => ++focused,
  };
  hand = new PullHand(element as unknown as HTMLElement, camera, events);
});

describe("a pull by keys", () => {
  it("grabs, moves along the picture's axes at most once a redraw, and lets go", () => {
    hand.grab(ray);
    const { triangle, barycentric } = hit;
    expect(sent).toEqual([{ command: "pull_begin", pull: 0, triangle, barycentric, target: hit.point }]);
    expect(focused).toBe(1);
    hand.tick(0);
    expect(sent.length).toBe(1);
    hand.nudge(0.5, 0, 0);
    hand.nudge(0, 0.25, 0);
    hand.nudge(0, 0, 0.125);
    hand.tick(16);
    hand.tick(32);
    expect(sent.length).toBe(2);
    const { target } = sent[1] as { target: readonly number[] };
    [1.125, 2.5, 3.25].forEach((x, i) => expect(target[i]).toBeCloseTo(x, 9));
    hand.letGo();
    expect(sent[2]).toEqual({ command: "pull_end", pull: 0 });
    expect(events.keyed.mock.calls).toEqual([[true], [false]]);
    hand.nudge(1, 0, 0);
    hand.letGo();
    hand.tick(48);
    expect(sent.length).toBe(3);
  });

  it.each([
    ["the keyboard goes elsewhere", () => listeners["blur"](), 2],
    ["the connection is lost, without a word", () => hand.drop(), 1],
  ])("ends when %s", (_, end, commands) => {
    hand.grab(ray);
    end();
    expect(hand.grip).toBeNull();
    expect(sent.length).toBe(commands);
    expect(events.keyed).toHaveBeenLastCalledWith(false);
  });

  it("goes on when a finger touches the picture, which is the camera's", () => {
    hand.grab(ray);
    const stopPropagation = vi.fn();
    listeners["pointerdown"]({ pointerType: "touch", pointerId: 7, button: 0, stopPropagation });
    expect(hand.grip?.byKeys).toBe(true);
    expect(sent.length).toBe(1);
    expect(stopPropagation).not.toHaveBeenCalled();
  });

  it("does not begin beside the object or while nothing can be pulled", () => {
    events.pick.mockReturnValue(null);
    hand.grab(ray);
    events.pick.mockReturnValue(hit);
    events.enabled.mockReturnValue(false);
    hand.grab(ray);
    expect([sent.length, focused, events.keyed.mock.calls.length]).toEqual([0, 0, 0]);
  });
});
