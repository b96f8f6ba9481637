/** Proposals of the open clip, and whether its project takes direct changes of this person. */
import { signal } from "@preact/signals";
import { get, type Schemas } from "../../api/client";
import { commented, news, proposed } from "../session/events";
import { askMe } from "../session/me";
import { editsIn } from "../session/rights";

export type Proposal = Schemas["ProposalView"];

/** edits: whether this person may edit in the project. review: whether changes there need a review. */
export const terms = signal({ edits: true, review: false });
/** Whether a change can be proposed alone. */
export const mustPropose = (): boolean => !terms.value.edits || terms.value.review;

/** Reason of the next change: for reviewers of a proposal, and in the history of the clip. */
export const message = signal("");

let followed: string | null = null;

export async function followTerms(project: string | null): Promise<void> {
  followed = project;
  if (project === null) return;
  const [me, about] = await Promise.all([askMe(), get("/project", { query: { project } }).catch(() => null)]);
  if (followed !== project) return;
  terms.value = { edits: me ? editsIn(me, project) : true, review: about?.review_required ?? false };
}

/** All proposals of the open clip, the newest first. */
export const proposals = signal<readonly Proposal[]>([]);
export const isPending = (one: Proposal): boolean => one.state === "open" || one.state === "approved";

let id: string | null = null;

export async function loadProposals(): Promise<void> {
  const wanted = id;
  if (wanted === null) return;
  // Who may not list them sees none.
  const found = await get("/documents/{id}/proposals", { path: { id: wanted }, query: { limit: 100 } }).catch(
    () => null,
  );
  if (id === wanted && found) proposals.value = found.items;
}

/** Follow the proposals of a clip, until what this answers is called. */
export function followProposals(clip: string): () => void {
  id = clip;
  proposals.value = [];
  void loadProposals();
  const again = (one: { document: string | null } | null) => {
    if (one?.document === clip) void loadProposals();
  };
  const stops = [proposed.subscribe(again), commented.subscribe(again), news.subscribe(again)];
  return () => {
    for (const stop of stops) stop();
    if (id === clip) id = null;
  };
}
