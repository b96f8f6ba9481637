/** Questions that were asked here, and those that were saved. */
import { kept } from "../session/settings";

export const asked = kept<string[]>("asked", []);
const MOST = 50;

export function remember(query: string): void {
  asked.value = [query, ...asked.peek().filter((one) => one !== query)].slice(0, MOST);
}
