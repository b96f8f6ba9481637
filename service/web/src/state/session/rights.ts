/** What somebody may do, as far as the studio shows it; the server decides. */
import { get, type Schemas } from "../../api/client";

/** Whether somebody decides about a project. */
export const ownsIn = (me: Schemas["Me"], project: string): boolean =>
  me.rights.includes("operate") ||
  (me.rights.includes("own") && me.projects.some((one) => one.project === project && one.role === "owner"));

/** Whether somebody may change what is in a project. Who has no account has the same right in all. */
export function editsIn(me: Schemas["Me"], project: string): boolean {
  const role = me.projects.find((one) => one.project === project)?.role ?? me.role;
  return me.rights.includes("edit") && role !== "reader" && role !== "member";
}

/** Who asks, and whether somebody owns the repository: known to those who may make the first account. */
export async function askOwned(signal: AbortSignal): Promise<Schemas["Me"] & { owned: boolean }> {
  const me = await get("/account", { signal });
  const people = me.role || !me.rights.includes("operate") ? null : await get("/accounts", { signal });
  return { ...me, owned: !people || people.items.some((one) => one.role === "owner" && !one.closed) };
}
