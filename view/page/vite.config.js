import { defineConfig } from "vite";

/// h5wasm contains its WebAssembly as a string in its JavaScript; a browser would scan it twice, decode it and only then compile.
/// Here it becomes a file, compiled during its transfer. The package version is pinned, so that its text is known.
function wasmAsFile() {
  const held = /function findWasmBinary\(\)\{return binaryDecode\(('(?:[^'\\]|\\.)*')\)\}/s;
  const started = "wasmBinaryFile??=findWasmBinary();var result=await instantiateAsync(wasmBinary,wasmBinaryFile,info)";
  return {
    name: "wasm-as-file",
    transform(code, id) {
      if (!id.endsWith("h5wasm/dist/esm/hdf5_util.js")) return null;
      const string = code.match(held)?.[1];
      if (!string || !code.includes(started)) throw new Error(`${id}: not the h5wasm that vite.config.js knows`);
      // As its own decoder does: a byte is its character; zero is a character beyond 255.
      const bytes = Uint8Array.from(new Function(`return ${string}`)(), (character) => {
        const c = character.charCodeAt(0);
        return (~c >> 8) & c;
      });
      const file = this.emitFile({ type: "asset", name: "h5wasm.wasm", source: bytes });
      return { code: code.replace(held, "").replace(started, `var result=await WebAssembly.instantiateStreaming(fetch(import.meta.ROLLUP_FILE_URL_${file}),info)`), map: null };
    },
  };
}

export default defineConfig({
  base: "/",
  esbuild: { charset: "utf8", legalComments: "none" },
  worker: { format: "es", plugins: () => [wasmAsFile()] },
  build: {
    target: "es2022",
    // Nothing inline: the server's content security policy admits files only.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 5000,
  },
});
