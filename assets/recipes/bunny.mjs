// Writes the Stanford bunny as an OBJ file, from npm package `bunny` (public domain; 1,839 vertices, closed).
//
//     node assets/recipes/bunny.mjs OUT.obj [PACKAGE_DIR]
//
// PACKAGE_DIR: the package's folder; default web/node_modules/bunny. The model keeps the package's axes (y is up) and is
// scaled to a height of 0.5 m, with its lowest point at y = 0 and the middle of its box at x = z = 0. The same package
// gives the same bytes. An existing OUT with these bytes is left untouched.
import { existsSync, mkdirSync, readFileSync, renameSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const height = 0.5; // metres

function fail(message) {
  console.error(`bunny.mjs: ${message}`);
  process.exit(2);
}

const [out, packageDir = join(dirname(fileURLToPath(import.meta.url)), '../../web/node_modules/bunny'), ...rest] =
  process.argv.slice(2);
if (!out || rest.length) fail('usage: node assets/recipes/bunny.mjs OUT.obj [PACKAGE_DIR]');
if (!existsSync(packageDir)) fail(`${packageDir} does not exist; run npm install in web/, or name the package's folder`);

const { positions, cells } = createRequire(import.meta.url)(resolve(packageDir));
if (!positions?.length || !cells?.length) fail(`${packageDir} holds no mesh`);

const low = [0, 1, 2].map((i) => Math.min(...positions.map((p) => p[i])));
const high = [0, 1, 2].map((i) => Math.max(...positions.map((p) => p[i])));
const scale = height / (high[1] - low[1]);
const origin = [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2];

const lines = ['# Stanford bunny, from npm package bunny; metres, y is up'];
for (const p of positions) lines.push(`v ${p.map((x, i) => ((x - origin[i]) * scale).toFixed(6)).join(' ')}`);
for (const c of cells) lines.push(`f ${c.map((v) => v + 1).join(' ')}`);
const text = lines.join('\n') + '\n';

if (!existsSync(out) || readFileSync(out, 'utf8') !== text) {
  mkdirSync(dirname(resolve(out)), { recursive: true });
  writeFileSync(`${out}.part`, text);
  renameSync(`${out}.part`, out); // never leave half a file behind
}
