import { kept } from "./settings";
export const saved = kept<string[]>("saved", []);
