import { brotliCompressSync, constants, gzipSync } from "node:zlib";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Plugin } from "vite";
import { defineConfig } from "vite";

/** Writes .gz and .br beside what compresses, so that the server only picks. */
function compressed(): Plugin {
  return {
    name: "compressed",
    closeBundle() {
      for (const name of readdirSync("static", { recursive: true, encoding: "utf8" })) {
        if (!/\.(js|css|html|svg)$/.test(name)) continue;
        const bytes = readFileSync(join("static", name));
        if (bytes.length < 1024) continue;
        writeFileSync(join("static", name + ".gz"), gzipSync(bytes, { level: 9 }));
        const quality = { [constants.BROTLI_PARAM_QUALITY]: 9 };
        writeFileSync(join("static", name + ".br"), brotliCompressSync(bytes, { params: quality }));
      }
    },
  };
}

export default defineConfig({
  base: "/",
  build: {
    outDir: "static",
    rollupOptions: { input: ["index.html", "shared.html"] },
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 700,
  },
  plugins: [compressed()],
  server: { proxy: { "/api": "http://127.0.0.1:8000" } },
});
