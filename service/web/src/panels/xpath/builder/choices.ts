/** Names that a condition can be about, with how many clips have each. */
import { get } from "../../../api/client";
import { useAsync } from "../../../ui/useAsync";

export interface Choice {
  text: string;
  count: number | null;
}

export interface Choices {
  names: Choice[];
  joints: Choice[];
  angles: Choice[];
}

export const useChoices = (project: string): Choices => ({
  names: useCompletions("//frame[motion_name='", project),
  joints: useCompletions("//frame_bone[@name='", project),
  angles: useCompletions("//frame[mo:angle('", project),
});

function useCompletions(before: string, project: string): Choice[] {
  const found = useAsync(
    (signal) => get("/xpath/complete", { query: { q: before, project: project || undefined }, signal }),
    [before, project],
  );
  const kinds = before.includes("angle") ? ["angle"] : ["bone name", "motion name"];
  return (found.value?.items ?? [])
    .filter((one) => kinds.includes(one.kind) && !one.detail.startsWith("goniometer"))
    .map((one) => ({ text: one.text, count: one.documents ?? null }))
    .sort((a, b) => (b.count ?? 0) - (a.count ?? 0) || (a.text < b.text ? -1 : 1));
}
