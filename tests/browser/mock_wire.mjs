// The bytes of server/PROTOCOL.md, written independently of the client's decoder.

function message(type, { generation, epoch = 0, sequence = 0, time = 0 }, [a, b, c], parts) {
  const header = Buffer.alloc(32);
  header.writeUInt8(type, 0);
  header.writeUInt8(1, 1);
  header.writeUInt16LE(generation, 2);
  header.writeUInt32LE(epoch, 4);
  header.writeUInt32LE(sequence, 8);
  header.writeUInt32LE(a, 12);
  header.writeDoubleLE(time, 16);
  header.writeUInt32LE(b, 24);
  header.writeUInt32LE(c, 28);
  const padded = parts.flatMap((part) => {
    const bytes = Buffer.from(part.buffer, part.byteOffset, part.byteLength);
    return [bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4)];
  });
  return Buffer.concat([header, ...padded]);
}

export function encodeModel({ triangles, young }, generation = 1) {
  return message(1, { generation }, [young.length, triangles.length / 3, 0], [triangles, young]);
}

export function encodeTopology(simulation) {
  const { generation, epoch, front, time } = simulation;
  const levels = simulation.surfaceLevels();
  const counts = [levels.length, front.levels.length, front.vertices.length / 3];
  const tets = [Uint32Array.of(front.tetLevels.length), front.tets, front.tetLevels];
  return message(2, { generation, epoch, time }, counts, [front.edges, levels, front.levels, ...tets]);
}

export const FIELDS = { displacement: 1, strain: 2, stress: 3, error: 4 };

/** wanted: colouring of the client; the last four make it a coloured frame. */
export function encodeFrame(simulation, wanted = "level") {
  const colouring = simulation.recorded?.colouring ?? wanted; // a recording's come unasked
  const surface = simulation.positions();
  const front = simulation.frontPositions();
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const points of [surface, front])
    points.forEach((x, i) => {
      low[i % 3] = Math.min(low[i % 3], x);
      high[i % 3] = Math.max(high[i % 3], x);
    });
  const extent = high.map((x, i) => x - low[i]);
  const pack = (points) =>
    Uint16Array.from(points, (x, i) => (extent[i % 3] > 0 ? ((x - low[i % 3]) / extent[i % 3]) * 65535 + 0.5 : 0));
  const pulls = [...simulation.pulls.values()].flatMap(({ from, target, force }) => [...from, ...target, force]);
  const parts = [Float32Array.from([...low, ...extent]), pack(surface), pack(front), Float32Array.from(pulls)];
  const counts = [surface.length / 3, front.length / 3, pulls.length / 7];
  if (!(colouring in FIELDS)) return message(3, simulation, counts, parts);
  const values = simulation.values(colouring, surface);
  const sorted = Float64Array.from(values).sort();
  const most = sorted.at(-1);
  const typical = sorted[Math.floor(0.98 * (sorted.length - 1))];
  const packed = Uint16Array.from(values, (x) => (most > 0 ? (x / most) * 65535 + 0.5 : 0));
  return message(4, simulation, counts, [
    ...parts,
    Uint32Array.of(FIELDS[colouring]),
    Float32Array.of(most, typical),
    packed,
  ]);
}
