/** What went wrong, where it concerns: in the server's words, with its remedy and a way to try again. */
import { ApiError, type Problem } from "../api/client";
import { w } from "../words";
import { Icon } from "./icons";
import { problemTitle } from "./problems/titles";

export function Trouble({ error, retry }: { error: unknown; retry?: () => void }) {
  if (!error) return null;
  const problem =
    error instanceof ApiError
      ? error.status === 412
        ? ({ title: w("error.staleWrite"), detail: w("error.staleHelp") } as Problem)
        : error.problem
      : null;
  return (
    <div class="banner" role="alert">
      <Icon name="warn" />
      <div class="grow">
        <strong>{problem ? problemTitle(problem) : (error as Error).message}</strong>
        {problem?.detail && problem.detail !== problem.title && <p>{problem.detail}</p>}
        {problem?.where && (
          <p class="dim">
            {[
              problem.where.file,
              problem.where.line && w("label.line", { n: problem.where.line }),
              problem.where.element,
            ]
              .filter(Boolean)
              .join(", ")}
          </p>
        )}
        {problem?.remedy && <p>{problem.remedy}</p>}
      </div>
      {retry && (
        <button type="button" class="button" onClick={retry}>
          {w("button.again")}
        </button>
      )}
    </div>
  );
}
