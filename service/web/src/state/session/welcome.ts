/** The first start: nothing here but the demo library, and nobody said that it is known. */
import { kept } from "./settings";

export const welcomed = kept("welcomed", false);

/** service/mcml_service/actions/importing/load_demo.py names them. */
const DEMO = new Set(["demo", "demo-reach", "demo-dance", "demo-walk", "demo-face"]);

export const isDemoAlone = (projects: readonly string[]): boolean =>
  projects.includes("demo") && projects.every((one) => DEMO.has(one));
