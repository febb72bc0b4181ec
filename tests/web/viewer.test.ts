import * as THREE from "three";
import { describe, expect, it } from "vitest";

import type { Command, Hello, Pin, Settings, Vec3 } from "../../web/src/messages";
import { decodeBinary } from "../../web/src/protocol";
import type { Frame } from "../../web/src/protocol";
import { initialState, Store } from "../../web/src/store";
import { heldPlaces } from "../../web/src/viewer/annotations";
import { Motion } from "../../web/src/viewer/motion";
import { computeNormals } from "../../web/src/viewer/normals";
import { pick, surfacePoint } from "../../web/src/viewer/pick";
import { PinHand } from "../../web/src/viewer/pins";
import { SceneForces } from "../../web/src/viewer/scene_forces";
import { niceStep } from "../../web/src/viewer/stage";
import { frame } from "./bytes";

// A tetrahedron with outward faces.
const corners = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1);
const faces = Uint32Array.of(0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3);

describe("a scene's force", () => {
  it("goes along with the nearest vertex until the server says where it is", () => {
    const forces = new SceneForces();
    forces.set([{ at: [1.25, 0, 0], value: [0, 0, 5] }], corners);
    expect(forces.at(corners)).toEqual([{ at: [1.25, 0, 0], value: [0, 0, 5] }]);
    const moved = corners.slice();
    moved[4] += 2; // y of the vertex at (1 0 0)
    expect(forces.at(moved)).toEqual([{ at: [1.25, 2, 0], value: [0, 0, 5] }]);
    forces.set([{ at: [1, 2.5, 0], value: [0, 0, 6] }], moved);
    expect(forces.at(moved)).toEqual([{ at: [1, 2.5, 0], value: [0, 0, 6] }]);
    expect(forces.at(new Float32Array(3))).toEqual([]); // of a smaller surface, before its own state comes
    forces.set([], moved);
    expect(forces.at(moved)).toEqual([]);
  });
});

describe("a pin", () => {
  const at = (triangle: number, corner: 0 | 1 | 2, radius: number, pinned = true): Pin => ({
    ...{ triangle, radius, pinned },
    barycentric: [0, 1, 2].map((i) => Number(i === corner)) as unknown as Vec3,
  });
  const surface = { positions: corners, triangles: faces };
  const origin = at(0, 0, 0.1);

  it("is marked where nothing said later lets it go", () => {
    expect(heldPlaces([origin, at(0, 2, 0.1)], surface)).toEqual([[0, 0, 0], [1, 0, 0]]); // prettier-ignore
    expect(heldPlaces([origin, at(0, 2, 1.5, false)], surface)).toEqual([]);
    expect(heldPlaces([at(0, 2, 1.5, false), origin], surface)).toEqual([[0, 0, 0]]);
    expect(heldPlaces([at(9, 0, 0.1)], surface)).toEqual([]); // of a larger surface
  });

  it("is let go as a whole, by what was said of it last", () => {
    const hello = { rest_box: [0, 0, 0, 1, 1, 1], capabilities: ["edit"] } as unknown as Hello;
    const pins = [at(0, 2, 0.1), origin];
    const settings = { pins } as unknown as Settings;
    const store = new Store({ ...initialState, link: { status: "open" }, hello, settings });
    const sent: Command[] = [];
    let point: Vec3 = [0.05, 0, 0];
    const hand = new PinHand(store, {
      pick: () => ({ triangle: 3, barycentric: [0.2, 0.3, 0.5], point, distance: 1 }),
      send: (command) => sent.push(command),
      place: ({ triangle, barycentric }) => surfacePoint(corners, faces, triangle, barycentric),
    });
    hand.act(new THREE.Ray());
    const { triangle, barycentric, radius } = origin;
    expect(sent.pop()).toEqual({ command: "unpin", triangle, barycentric, radius });
    point = [0.5, 0.5, 0];
    hand.act(new THREE.Ray());
    expect(sent.pop()).toMatchObject({ command: "pin", triangle: 3 });
    hand.act(new THREE.Ray(), false); // what the scene itself may hold there
    expect(sent.pop()).toMatchObject({ command: "unpin", triangle: 3 });
  });
});

describe("computeNormals", () => {
  it("gives unit vectors, weighted by area, and 0 where there is no triangle", () => {
    const positions = Float32Array.of(...corners, 9, 9, 9);
    const normals = new Float32Array(15).fill(7);
    computeNormals(positions, faces, normals);
    const s = 1 / Math.sqrt(3);
    // At the origin three equal right triangles meet.
    [-s, -s, -s].forEach((x, i) => expect(normals[i]).toBeCloseTo(x, 6));
    for (let v = 0; v < 4; ++v) expect(Math.hypot(...normals.subarray(3 * v, 3 * v + 3))).toBeCloseTo(1, 6);
    expect([...normals.subarray(12)]).toEqual([0, 0, 0]);
  });

  it("is the direction from the centre on a ball", () => {
    const n = 24;
    const positions: number[] = [];
    const triangles: number[] = [];
    for (let i = 0; i <= n; ++i)
      for (let j = 0; j < n; ++j) {
        const [theta, phi] = [(Math.PI * (i + 0.5)) / (n + 1), (2 * Math.PI * j) / n];
        positions.push(Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta));
        const [a, b] = [i * n + j, i * n + ((j + 1) % n)];
        if (i < n) triangles.push(a, a + n, b, b, a + n, b + n);
      }
    const normals = new Float32Array(positions.length);
    computeNormals(Float32Array.from(positions), Uint32Array.from(triangles), normals);
    for (let i = 3 * n; i < positions.length - 3 * n; i += 3) {
      const cosine = normals[i] * positions[i] + normals[i + 1] * positions[i + 1] + normals[i + 2] * positions[i + 2];
      expect(cosine).toBeGreaterThan(0.98);
    }
  });
});

describe("pick", () => {
  it("finds the nearest triangle and where in it", () => {
    const hit = pick(corners, faces, [0.2, 0.3, -2], [0, 0, 1])!;
    expect(hit.triangle).toBe(0); // the bottom, not the slanted face behind it
    expect(hit.distance).toBeCloseTo(2, 6);
    const again = surfacePoint(corners, faces, hit.triangle, hit.barycentric);
    [0.2, 0.3, 0].forEach((x, i) => {
      expect(hit.point[i]).toBeCloseTo(x, 6);
      expect(again[i]).toBeCloseTo(x, 6);
    });
    expect(hit.barycentric.reduce((a, b) => a + b)).toBeCloseTo(1, 12);
  });

  it("misses beside, behind, and along a face", () => {
    expect(pick(corners, faces, [0.8, 0.8, -2], [0, 0, 1])).toBeNull();
    expect(pick(corners, faces, [0.2, 0.3, -2], [0, 0, -1])).toBeNull();
    expect(pick(corners, Uint32Array.of(0, 1, 2), [-1, 0.2, 0], [1, 0, 0])).toBeNull();
  });

  it("grabs the inside of an open surface too", () => {
    expect(pick(corners, Uint32Array.of(0, 2, 1), [0.2, 0.2, 2], [0, 0, -1])?.triangle).toBe(0);
  });
});

describe("Motion", () => {
  const decoded = (...args: Parameters<typeof frame>) => decodeBinary(frame(...args)) as Frame;
  const sampleX = (motion: Motion, now: number) => {
    const surface = new Float32Array(9);
    const front = new Float32Array(8);
    motion.sample(now, surface, front);
    return [surface[0], front[0]];
  };

  it("shows a first frame at once and then rests", () => {
    const motion = new Motion();
    expect(motion.moving).toBe(false);
    motion.push(decoded(1, { x: 5 }), 1000);
    expect(motion.moving).toBe(true);
    expect(sampleX(motion, 1000)).toEqual([5, 5]);
    expect(motion.moving).toBe(false);
    motion.touch();
    expect(motion.moving).toBe(true);
  });

  it("goes from frame to frame in the time between them", () => {
    const motion = new Motion();
    for (let i = 0; i <= 60; ++i) motion.push(decoded(1, { time: i, x: i }), 1000 + 33 * i);
    const at = (ms: number) => sampleX(motion, 1000 + 33 * 60 + ms)[0];
    expect(at(0)).toBeCloseTo(59, 5);
    expect(at(16.5)).toBeCloseTo(59.5, 2);
    expect(motion.moving).toBe(true);
    expect(at(40)).toBeCloseTo(60, 5);
    expect(motion.moving).toBe(false);
  });

  it("jumps back at a reset, and after a pause", () => {
    const motion = new Motion();
    motion.push(decoded(1, { time: 5, x: 1 }), 1000);
    motion.push(decoded(1, { time: 0, x: 2 }), 1010);
    expect(sampleX(motion, 1010)[0]).toBe(2);
    motion.push(decoded(1, { time: 1, x: 3 }), 5000);
    expect(sampleX(motion, 5000)[0]).toBe(3);
  });

  it("mixes the surface across epochs, but never the front", () => {
    const motion = new Motion();
    motion.push(decoded(1, { time: 0, x: 0 }), 1000);
    motion.push(decoded(2, { time: 1, x: 1 }), 1020);
    const [surface, front] = sampleX(motion, 1021);
    expect(surface).toBeLessThan(0.5);
    expect(front).toBe(1);
  });
});

it("niceStep is 1, 2 or 5 times a power of ten", () => {
  expect([0.0019, 0.002, 0.7, 9.99, 10].map(niceStep)).toEqual([0.001, 0.002, 0.5, 5, 10]);
});
