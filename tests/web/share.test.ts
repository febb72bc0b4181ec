import { describe, expect, it } from "vitest";

import { cutOf, planeOf } from "../../web/src/cut";
import type { Hello, Settings, SimulationState } from "../../web/src/messages";
import { fromFragment, toFragment } from "../../web/src/share";
import { isRecordingOf, snapshotQuery } from "../../web/src/snapshot";
import { initialState } from "../../web/src/store";
import type { State } from "../../web/src/store";

const settings: Settings = {
  ...{ type: "settings", order: 2, levels: { min: 0, max: 1 }, stiffness_scale: 1, damping: { mass: 0, stiffness: 0 } },
  ...{ budget: { tets: null, milliseconds: null }, forces: [], pins: [] },
};
const asInTheScene: State = {
  ...initialState,
  link: { status: "open" },
  hello: {
    scene: { name: "bunny & co", title: "" },
    view: { eye: [0, 0, 1], target: [0, 0, 0], field_of_view: 35, colouring: "level", wireframe: false },
    depth: 2,
    tolerance: 0.03,
    gravity: [0, 0, -9.81],
    order: 2,
    levels: { min: 0, max: 2 },
    budget: { tets: null, milliseconds: null },
    capabilities: ["colouring"],
    rest_box: [0, 0, 0, 2, 4, 6],
  } as unknown as Hello,
  simulation: { speed: 1, tolerance: 0.03, gravity: [0, 0, -9.81] } as unknown as SimulationState,
  settings,
};

describe("the address", () => {
  it("is empty when all is as in the scene", () => expect(toFragment(asInTheScene, null)).toBe(""));

  it("carries the view and the values over to another page", () => {
    const changed: State = {
      ...asInTheScene,
      ...{ colouring: "stress", wireframe: true, shape: "tets", explode: 0.25 },
      cut: { axis: 1, at: 0.4, flip: true },
      simulation: { speed: 0.5, tolerance: 0.01, gravity: [1, 0, 0] } as unknown as SimulationState,
      settings: {
        ...settings,
        ...{ order: 1, levels: { min: 1, max: 1 }, stiffness_scale: 2, damping: { mass: 1, stiffness: 0.01 } },
        budget: { tets: 500, milliseconds: null },
      },
    };
    const shared = fromFragment(`#${toFragment(changed, [1, 2, 3, 0, 0, 0.5])}`);
    const { colouring, wireframe, shape, explode, cut } = changed;
    expect(shared.scene).toBe("bunny & co");
    expect(shared.view).toEqual({ colouring, wireframe, shape, explode, cut });
    expect(shared.camera).toEqual({ eye: [1, 2, 3], target: [0, 0, 0.5] });
    expect(shared.commands).toEqual([
      { command: "speed", value: 0.5 },
      { command: "tolerance", value: 0.01 },
      { command: "order", value: 1 },
      { command: "levels", min: 1, max: 1 },
      { command: "stiffness_scale", value: 2 },
      { command: "gravity", value: [1, 0, 0] },
      { command: "damping", mass: 1, stiffness: 0.01 },
      { command: "budget", tets: 500 },
    ]);
  });

  it("says nothing of levels that only follow the order", () => {
    const linear: State = { ...asInTheScene, settings: { ...settings, order: 1, levels: { min: 0, max: 2 } } };
    expect(toFragment(linear, null)).toBe("scene=bunny%20%26%20co&order=1");
  });

  it("counts by what the scene says, not by what is so when the page comes", () => {
    const hello = { ...asInTheScene.hello!, levels: { min: 1, max: 1 }, budget: { tets: 500, milliseconds: null } };
    // The tree is deeper than the scene goes: its finest level is no choice of anybody.
    const scene = { ...settings, levels: { min: 1, max: 1 }, budget: hello.budget };
    expect(toFragment({ ...asInTheScene, hello, settings: scene }, null)).toBe("");
    const linear = { ...scene, order: 1 };
    expect(toFragment({ ...asInTheScene, hello, settings: linear }, null)).toBe("scene=bunny%20%26%20co&order=1");
    const deeper = { ...linear, levels: { min: 1, max: 2 } };
    expect(toFragment({ ...asInTheScene, hello, settings: deeper }, null)).toContain("&levels=1,2");
    const damped = { ...scene, damping: { mass: 2, stiffness: 0 }, budget: { tets: null, milliseconds: null } };
    expect(toFragment({ ...asInTheScene, hello, settings: damped }, null)).toContain("&damping=2,0&budget=,");
  });

  it("carries a cut only when it is not the scene's", () => {
    const { hello } = asInTheScene;
    const view = { ...hello!.view, cut: { point: [0.5, 9, 9], normal: [3, 0, 0] } };
    const open: State = { ...asInTheScene, hello: { ...hello!, view } };
    const cut = { axis: 0, at: 0.25, flip: false } as const;
    expect(toFragment({ ...open, cut }, null)).toBe("");
    const closed = toFragment(open, null);
    expect(closed).toContain("cut=none");
    expect(fromFragment(closed).view).toEqual({ cut: null });
    // The plane that the server is given for it is the scene's.
    expect(planeOf(cut, hello!.rest_box)).toEqual({ point: [0.5, 2, 3], normal: [1, 0, 0] });
    for (const normal of [[1, 1, 0], [0, 0, 0]]) expect(cutOf({ ...view.cut, normal }, hello!.rest_box)).toBeNull(); // prettier-ignore
    expect(cutOf({ ...view.cut, point: [-1, 0, 0] }, hello!.rest_box)).toBeNull();
  });

  it.each(["", "#", "#colour=nonsense&cut=q,2&levels=1&camera=1,2&gravity=a,b,c&tolerance=x&explode=", "#%E0%A4%A"])(
    "ignores what it does not understand: %s",
    (fragment) => {
      const shared = fromFragment(fragment);
      expect(shared.view).toEqual({});
      expect(shared.camera).toBeNull();
      expect(shared.commands).toEqual([]);
    },
  );
});

describe("a snapshot", () => {
  it("shows what the panels leave free, at the same angle", () => {
    const framing = {
      ...{ eye: [0, 0, 1] as const, target: [0, 0, 0] as const, field_of_view: 60, width: 1000, height: 500 },
      covered: { top: 50, bottom: 50, left: 100, right: 200 },
    };
    const cut = { axis: 2, at: 0.5, flip: false } as const;
    const query = new URLSearchParams(snapshotQuery({ ...asInTheScene, cut }, framing));
    expect([query.get("w"), query.get("h")]).toEqual(["700", "400"]);
    const view = JSON.parse(query.get("view") ?? "") as Record<string, unknown>;
    const half = (degrees: number) => Math.tan((degrees * Math.PI) / 360);
    expect(half(view["field_of_view"] as number)).toBeCloseTo(half(60) * 0.8, 9);
    expect(view).toMatchObject({ cut: { point: [1, 2, 3], normal: [0, 0, 1] }, background: "light" });
    const bare = new URLSearchParams(snapshotQuery({ ...asInTheScene, transparent: true }, framing));
    expect(JSON.parse(bare.get("view") ?? "")).toMatchObject({ background: "transparent" });
  });
});

describe("a recording's scene", () => {
  it.each([
    ["box", "box-20260131-235959.tfr", true],
    ["box", "box-2-20260131-235959.tfr", false], // of a scene that is called box-2
    ["box-2", "box-2-20260131-235959.tfr", true],
    ["box", "box-before-lunch.tfr", false],
    ["two boxes", "two-boxes-20260131-235959.tfr", true],
    ["a".repeat(60), `${"a".repeat(40)}-20260131-235959.tfr`, true],
  ])("%s: %s %s", (scene, name, same) => expect(isRecordingOf(scene, name)).toBe(same));
});
