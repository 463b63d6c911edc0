import { defineConfig } from "vite";

// Three files with fixed names, which the crate embeds: the page, its script, its style.
export default defineConfig({
  esbuild: { jsx: "automatic", jsxImportSource: "preact", legalComments: "none" },
  build: {
    target: "es2022",
    modulePreload: false,
    assetsInlineLimit: 0,
    rollupOptions: {
      output: {
        entryFileNames: "lab.js",
        inlineDynamicImports: true,
        assetFileNames: "lab[extname]",
      },
    },
  },
});
