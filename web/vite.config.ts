import { defineConfig } from "vite";

// Relative URLs, so that the page also works below a path; nothing inlined, so that `default-src 'self'` is enough.
export default defineConfig({
  base: "./",
  build: { target: "es2022", assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 900 },
  worker: { format: "es" },
});
