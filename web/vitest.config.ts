import { fileURLToPath } from "node:url";
import { defineConfig } from "vitest/config";

const path = (relative: string) => fileURLToPath(new URL(relative, import.meta.url));

// tests/web mirrors web/src; it lies outside of this folder, so packages are found by alias.
export default defineConfig({
  root: path(".."),
  server: { fs: { allow: [path("..")] } },
  resolve: { alias: { three: path("node_modules/three"), meshoptimizer: path("node_modules/meshoptimizer") } },
  test: { include: ["tests/web/**/*.test.ts"], environment: "node" },
});
