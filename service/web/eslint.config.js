/** The studio's rules: `python -m tests.web.keeper style`, a part of `make check`. */
import eslint from "@eslint/js";
import jsxA11y from "eslint-plugin-jsx-a11y";
import reactHooks from "eslint-plugin-react-hooks";
import tseslint from "typescript-eslint";

const MOST_LINES = 150;
const MOST_COMPLEX = 15;

/** Files with a function of more lines than MOST_LINES, with its lines. Shorten a function, lower its number; add no file. */
const LONG = {
  "src/panels/reach/Examples.tsx": 163,
  "src/panels/clip/body/Body.tsx": 158,
  "src/panels/clip/document/Info.tsx": 207,
  "src/panels/clip/document/Tree.tsx": 238,
  "src/panels/clip/timeline/Graph.tsx": 233,
  "src/panels/clip/timeline/Timeline.tsx": 218,
  "src/panels/clip/viewer/ViewerPane.tsx": 215,
  "src/panels/composer/ComposerPage.tsx": 188,
  "src/panels/dance/BenchBar.tsx": 241,
  "src/panels/faces/MapView.tsx": 183,
  "src/panels/faces/Walk.tsx": 237,
  "src/panels/retarget/Many.tsx": 176,
  "src/panels/retarget/RetargetPage.tsx": 218,
};

/** Files with a function that is more complex than MOST_COMPLEX, with its complexity. As LONG. */
const COMPLEX = {
  "src/panels/analyses/ResultPage.tsx": 24,
  "src/panels/reach/ExampleRow.tsx": 17,
  "src/panels/reach/Fit.tsx": 18,
  "src/panels/reach/Trust.tsx": 18,
  "src/panels/clip/body/Body.tsx": 28,
  "src/panels/clip/document/Tree.tsx": 33,
  "src/panels/composer/ComposerPage.tsx": 22,
  "src/panels/composer/Storyboard.tsx": 30,
  "src/panels/dance/GraphPane.tsx": 27,
  "src/panels/dance/PathStrip.tsx": 16,
  "src/panels/faces/MapView.tsx": 19,
  "src/panels/library/LibraryPage.tsx": 18,
  "src/panels/library/UploadTray.tsx": 18,
  "src/panels/retarget/Many.tsx": 32,
  "src/panels/retarget/RetargetPage.tsx": 19,
  "src/panels/settings/ProjectPage.tsx": 18,
};

const lines = (max) => ({ "max-lines-per-function": ["error", { max, skipBlankLines: true, skipComments: true }] });
const exceptions = (table, ruleOf) =>
  Object.entries(table).map(([file, most]) => ({ files: [file], rules: ruleOf(most) }));

// Other known findings are counted in eslint-suppressions.json: the check fails for each that is new, and for each count
// that is too high (`eslint --prune-suppressions` lowers them).
export default tseslint.config(
  { ignores: ["static", "node_modules", "src/api/types.gen.ts", "*.js", "*.cjs"] },
  eslint.configs.recommended,
  tseslint.configs.strictTypeChecked,
  jsxA11y.flatConfigs.recommended,
  {
    languageOptions: { parserOptions: { projectService: true, tsconfigRootDir: import.meta.dirname } },
    plugins: { "react-hooks": reactHooks },
    rules: {
      "react-hooks/rules-of-hooks": "error",
      "react-hooks/exhaustive-deps": "error",
      ...lines(MOST_LINES),
      complexity: ["error", MOST_COMPLEX],
      // A handler in one line may return what it assigns or calls.
      "@typescript-eslint/no-confusing-void-expression": ["error", { ignoreArrowShorthand: true }],
      // `void` says that nobody waits for a promise; not every function declares whether it makes one.
      "@typescript-eslint/no-meaningless-void-operator": "off",
      "@typescript-eslint/restrict-template-expressions": ["error", { allowNumber: true }],
      // Reading a signal in an effect is what makes the effect run again.
      "@typescript-eslint/no-unused-expressions": "off",
      // A dialog's first field has the focus: those who ask for the dialog are about to type.
      "jsx-a11y/no-autofocus": "off",
      // Regions that scroll take the focus, or the keyboard could not scroll them (axe: scrollable-region-focusable).
      "jsx-a11y/no-noninteractive-tabindex": "off",
    },
  },
  ...exceptions(LONG, lines),
  ...exceptions(COMPLEX, (most) => ({ complexity: ["error", most] })),
  {
    // Functions of tests hold one story; fakes answer at once.
    files: ["src/**/*.test.ts", "src/**/*.test.tsx", "src/testing/**"],
    rules: {
      "max-lines-per-function": "off",
      "@typescript-eslint/no-non-null-assertion": "off",
      "@typescript-eslint/require-await": "off",
      // Files share modules (tests/web/test_units.py): one that another file has loaded before is not replaced any more.
      "no-restricted-properties": [
        "error",
        { object: "vi", property: "mock", message: "Replace what the browser gives (vi.spyOn, vi.stubGlobal)." },
      ],
    },
  },
);
