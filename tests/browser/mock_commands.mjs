// What the mock does for the commands of server/PROTOCOL.md beyond playing and pulling.

import { encodeFrame, FIELDS } from "./mock_wire.mjs";

export const SCENES = [
  { name: "mock", title: "Wobbling ball (mock)" },
  { name: "coarse", title: "A coarser ball (mock)", detail: 3 },
];

/** Commands that change what "settings" says. */
export function editCommand(simulation, { command, ...keys }) {
  delete keys.id;
  switch (command) {
    case "force_add":
      simulation.forces = [...simulation.forces.filter(({ force }) => force !== keys.force), keys];
      break;
    case "force_move":
      if (!simulation.forces.some(({ force }) => force === keys.force))
        return { code: "unknown_name", pointer: "/force", message: "there is no such force" };
      simulation.forces = simulation.forces.map((force) =>
        force.force === keys.force ? { ...force, ...keys } : force,
      );
      break;
    case "force_remove":
      simulation.forces = simulation.forces.filter(({ force }) => force !== keys.force);
      break;
    case "pin":
    case "unpin":
      simulation.pins = [
        ...simulation.pins.filter((pin) => !isSamePart(pin, keys)),
        { pinned: command === "pin", ...keys },
      ];
      break;
    case "stiffness_scale": {
      if (!("radius" in keys)) {
        simulation.stiffness = keys.value;
        break;
      }
      const others = simulation.stiffnessParts.filter((part) => !isSamePart(part, keys));
      const parts = [...others, keys];
      while (parts[0]?.value === 1) parts.shift();
      if (parts.length > 64) return { code: "too_many", pointer: "", message: "parts have 64 stiffnesses already" };
      simulation.stiffnessParts = parts;
      break;
    }
    case "damping":
      simulation.damping = keys;
      break;
    case "order":
      simulation.order = keys.value;
      simulation.limitLevels();
      break;
    case "levels":
      simulation.wantedLevels = { min: keys.min, max: keys.max };
      simulation.limitLevels();
      break;
    case "budget":
      simulation.budget = { tets: keys.tets ?? null, milliseconds: keys.milliseconds ?? null };
      break;
    default:
      return undefined;
  }
  simulation.tell(simulation.settings());
  simulation.broadcast();
  return {};
}

const isSamePart = (a, b) =>
  a.triangle === b.triangle && a.radius === b.radius && a.barycentric.join() === b.barycentric.join();

/** Commands about colours, scenes and recordings. */
export function keepCommand(simulation, viewer, { command, value, scene }) {
  switch (command) {
    case "colouring": {
      const { recorded } = simulation;
      if (recorded && value in FIELDS && value !== recorded.colouring)
        return { code: "failed", pointer: "/value", message: "was not recorded" };
      viewer.colouring = value;
      viewer.socket.send(encodeFrame(simulation, value));
      return {};
    }
    case "scenes":
      return { scenes: SCENES };
    case "load": {
      const wanted = SCENES.find(({ name }) => name === scene);
      if (!wanted) return { code: "unknown_name", pointer: "/scene", message: "there is no such scene" };
      simulation.load(wanted);
      return {};
    }
    case "recordings":
      return { recordings: simulation.recordings, video: true };
    case "record_start":
      if (simulation.recording) return { code: "failed", pointer: "", message: "is recording already" };
      simulation.recording = { name: `mock-${simulation.recordings.length + 1}.tfr`, frames: 0 };
      simulation.tell(simulation.recordingState());
      return {};
    case "record_stop":
      if (simulation.recording)
        simulation.recordings = [
          ...simulation.recordings,
          { name: simulation.recording.name, bytes: 12_000 * simulation.recording.frames },
        ];
      simulation.recording = null;
      simulation.tell(simulation.recordingState());
      return {};
    default:
      return undefined;
  }
}
