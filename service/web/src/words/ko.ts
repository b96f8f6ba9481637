import { en } from "./en";
export const ko: typeof en = { ...en };
