import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

const path = (relative: string) => fileURLToPath(new URL(relative, import.meta.url));
const packages = ["playwright-core", "pngjs", "axe-core", "ws"];

// Stories in a real Chromium: one file per story, one at a time (the software rasteriser uses every core).
// With `--mode report`: the programs that write tests/reports/browser.md.
export default defineConfig(({ mode }) => ({
  root: path(".."),
  server: { fs: { allow: [path("..")] } },
  resolve: { alias: Object.fromEntries(packages.map((name) => [name, path(`node_modules/${name}`)])) },
  test: {
    include: [`tests/browser/**/*.${mode === "report" ? "report" : "story"}.ts`],
    environment: "node",
    fileParallelism: false,
    testTimeout: 120_000,
    hookTimeout: 120_000,
  },
}));
