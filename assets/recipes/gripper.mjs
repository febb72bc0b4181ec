// Writes the gripper of gripper.json as tets: a palm and two fingers of stiff links, joined by soft webs.
//
//     node assets/recipes/gripper.mjs assets/scenes/gripper.mesh
//
// Medit text, metres, z is up. Regions: 1 palm and links, 2 joints. Boxes of a grid whose lines follow the parts, each cut in
// six tets, so that no tet holds two materials.
import { renameSync, writeFileSync } from 'node:fs';

const x = [-0.13, -0.115, -0.09, -0.03, 0.03, 0.09, 0.115, 0.13];
const y = [-0.02, 0.02];
const z = [0, 0.04, 0.08, 0.12, 0.14, 0.19, 0.24, 0.26, 0.3];
const [stiff, soft] = [1, 2];

/** Region of the grid's box with middle (cx, cz); 0: empty. */
function region(cx, cz) {
  const across = Math.abs(cx);
  if (cz > 0.26) return stiff; // palm
  const joint = (cz > 0.12 && cz < 0.14) || cz > 0.24; // webs on the outside: fingers bend inwards
  if (joint) return across > 0.115 ? soft : 0;
  return across > 0.09 ? stiff : 0;
}

const vertices = new Map(); // "i j k" -> number from 1
const number = (i, j, k) => {
  const key = `${i} ${j} ${k}`;
  if (!vertices.has(key)) vertices.set(key, vertices.size + 1);
  return vertices.get(key);
};
const middle = (lines, i) => (lines[i] + lines[i + 1]) / 2;
const tets = [];
for (let k = 0; k + 1 < z.length; ++k)
  for (let j = 0; j + 1 < y.length; ++j)
    for (let i = 0; i + 1 < x.length; ++i) {
      const material = region(middle(x, i), middle(z, k));
      if (!material) continue;
      // Kuhn: one tet for each order of walking along the three axes from the lowest corner to the highest.
      for (const [a, b, odd] of [[0, 1, 0], [1, 2, 0], [2, 0, 0], [1, 0, 1], [2, 1, 1], [0, 2, 1]]) {
        const corner = [i, j, k];
        const walk = [number(...corner)];
        for (const axis of [a, b, 3 - a - b]) {
          ++corner[axis];
          walk.push(number(...corner));
        }
        if (odd) [walk[2], walk[3]] = [walk[3], walk[2]];
        tets.push(`${walk.join(' ')} ${material}`);
      }
    }

const out = process.argv[2];
if (!out || process.argv.length > 3) {
  console.error('usage: node assets/recipes/gripper.mjs OUT.mesh');
  process.exit(2);
}
const places = [...vertices.keys()].map((key) => {
  const [i, j, k] = key.split(' ').map(Number);
  return `${x[i]} ${y[j]} ${z[k]} 0`;
});
writeFileSync(
  `${out}.part`,
  ['# A gripper, by assets/recipes/gripper.mjs; regions: 1 palm and links, 2 joints', 'MeshVersionFormatted 2', 'Dimension 3',
    `Vertices ${places.length}`, ...places, `Tetrahedra ${tets.length}`, ...tets, 'End', ''].join('\n'),
);
renameSync(`${out}.part`, out); // never leave half a file behind
