/** How many proposals wait for a review; leads to them. */
import { isPending, proposals } from "../../../state/clip/review";
import { param, setParams } from "../../../state/session/route";
import { rightFolded } from "../../../state/session/panes";
import { r } from "../words";

export function PendingProposals() {
  const n = proposals.value.filter(isPending).length;
  if (!n || param("tab") === "proposals") return null;
  return (
    <button
      type="button"
      class="button"
      onClick={() => {
        rightFolded.value = false;
        setParams({ tab: "proposals" });
      }}
    >
      {r("label.pending", { n })}
    </button>
  );
}
