import { defineConfig } from "vite";

// The server embeds the files under a path that is known only at run time: addresses are relative
// and names fixed.
export default defineConfig({
    base: "./",
    // A test compares docs/editor.md with the table of shortcuts.
    server: { fs: { allow: ["../../.."] } },
    build: {
        target: "es2022",
        modulePreload: false,
        cssCodeSplit: false,
        chunkSizeWarningLimit: 1024,
        rollupOptions: {
            output: {
                entryFileNames: "assets/editor.js",
                assetFileNames: "assets/editor[extname]",
                inlineDynamicImports: true,
            },
        },
    },
});
