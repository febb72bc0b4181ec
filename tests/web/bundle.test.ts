// What a browser loads before it shows anything is small: the page with all that belongs to it, as a server would compress it.

import { existsSync, readdirSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";
import { describe, expect, it } from "vitest";

const DIST = fileURLToPath(new URL("../../web/dist/", import.meta.url));
const LIMIT = 300_000; // [bytes]

describe("the bundle", () => {
  it(`is below ${LIMIT / 1000} kB gzipped`, () => {
    if (!existsSync(`${DIST}index.html`)) throw new Error(`there is no ${DIST}index.html: npm --prefix web run build`);
    const page = readFileSync(`${DIST}index.html`, "utf8");
    const files = (readdirSync(DIST, { recursive: true }) as string[]).filter((name) =>
      /\.(html|js|css|svg|wasm)$/.test(name),
    );
    // All that the page names is there and counted.
    const named = [...page.matchAll(/(?:src|href)="\.\/([^"]+)"/g)].map(([, name]) => name);
    expect(named.some((name) => name.endsWith(".js")) && named.some((name) => name.endsWith(".css"))).toBe(true);
    for (const name of named) expect(files).toContain(name);
    const sizes = files.map((name) => ({ name, bytes: gzipSync(readFileSync(DIST + name), { level: 9 }).length }));
    const total = sizes.reduce((sum, { bytes }) => sum + bytes, 0);
    const list = sizes.map(({ name, bytes }) => `${name} ${bytes}`).join(", ");
    expect(total, `gzipped bytes of ${list}`).toBeLessThan(LIMIT);
    expect(total, "bytes of a bundle without three.js are too few to be ours").toBeGreaterThan(100_000);
  });
});
