import { defineConfig } from "vitest/config";

export default defineConfig({
  test: {
    // pytest ends a run that hangs: a busy machine takes longer than the usual five seconds.
    testTimeout: 120_000,
    hookTimeout: 120_000,
    coverage: {
      provider: "v8",
      include: ["src/state/**", "src/motion/**"],
      reporter: ["text-summary"],
      thresholds: { lines: 80 },
      reportsDirectory: "node_modules/.coverage",
    },
  },
});
