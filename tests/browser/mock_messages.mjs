// What the mock says in JSON, as in server/PROTOCOL.md.

const CAPABILITIES = ["acknowledge", "colouring", "edit", "load", "record", "save"];

/** The scene's own, whatever commands have set since. */
export const SCENE = { gravity: [0, 0, -9.81], tolerance: 0.05, order: 1, levels: { min: 0, max: 2 } };
export const NO_BUDGET = { tets: null, milliseconds: null };

export function helloOf({ scene, timeStep, playing, speed, recorded, generation, cut, lacks }) {
  return {
    type: "hello",
    protocol: 1,
    version: "0.0.0-mock",
    scene: { name: scene.name, title: scene.title },
    up: 2,
    depth: 2,
    young_range: [1e5, 1e7],
    rest_box: [-0.5, -0.5, 0, 0.5, 0.5, 1],
    view: {
      ...{ eye: [1.6, -2.9, 1.5], target: [0, 0, 0.48], field_of_view: 32 },
      ...{ colouring: "level", wireframe: false, ...(cut ? { cut } : {}) },
    },
    ...{ ...SCENE, budget: NO_BUDGET },
    time_step: timeStep,
    playing,
    speed,
    recording: recorded,
    generation,
    limits: { message_bytes: 65536, messages_per_second: 1000, recording_bytes: 1e9 },
    capabilities: CAPABILITIES.filter(
      (name) => !lacks.includes(name) && !(recorded && ["edit", "record", "save"].includes(name)),
    ),
  };
}

export function stateOf(simulation) {
  const { playing, speed, time, step, tolerance, gravity, warning, failed, fine, timeStep } = simulation;
  return {
    type: "state",
    ...{ playing, speed, time, step, tolerance, gravity, warning, failed },
    steps_per_second: playing ? speed / timeStep : 0,
    tets_by_level: fine ? [620, 1480, 2210] : [720, 880, 0],
    free_vertices: fine ? 1432 : 412,
    estimate: fine ? 0.021 : 0.034,
    milliseconds: fine ? 7.31 : 2.04,
    phases: fine
      ? { adapt: 1.1, setup: 0.9, assemble: 1.6, solve: 3.2, other: 0.51 }
      : { adapt: 0.2, setup: 0.3, assemble: 0.5, solve: 0.9, other: 0.14 },
    energy: { kinetic: 0.4 * Math.cos(4 * time) ** 2, elastic: 1 + 0.4 * Math.sin(4 * time) ** 2 },
    iterations: 14,
    converged: true,
    viewers: simulation.viewers.size,
    forces: simulation.sceneForces,
  };
}

export function settingsOf({ order, levels, damping, budget, forces, pins, stiffness, stiffnessParts }) {
  const scales = { stiffness_scale: stiffness, stiffness_parts: stiffnessParts };
  return { type: "settings", order, levels, ...scales, damping, budget, forces, pins };
}

export function recordingOf({ recording }) {
  const { name = "", frames = 0 } = recording ?? {};
  const active = recording !== null;
  return { type: "recording", active, name, frames, seconds: frames / 30, bytes: 12_000 * frames, problem: "" };
}
