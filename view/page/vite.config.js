import { defineConfig } from "vite";

export default defineConfig({
  base: "/",
  // The WebAssembly of h5wasm is a string in its JavaScript: escaped, it would be four times as long.
  esbuild: { charset: "utf8", legalComments: "none" },
  worker: { format: "es" },
  build: {
    target: "es2022",
    // Nothing inline: the server's content security policy takes files only.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 5000,
  },
});
