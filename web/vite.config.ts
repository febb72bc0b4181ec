import { defineConfig } from "vite";

// Relative URLs, so that the page also works below a path; nothing inlined, so that `default-src 'self'` is enough.
export default defineConfig({
  base: "./",
  build: { target: "es2022", assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 900 },
  worker: { format: "es" },
  // `npm run dev` beside a `tetfront serve` on its default port.
  server: { proxy: { "/ws": { target: "ws://127.0.0.1:8080", ws: true, changeOrigin: true, rewriteWsOrigin: true } } },
});
