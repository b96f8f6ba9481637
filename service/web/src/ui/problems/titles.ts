/** Titles of problems in the language of the studio, by their types (RFC 9457); others as the server has them. */
import type { Problem } from "../../api/client";
import { p, type ProblemWord } from "./words";

export function problemTitle({ type, title }: Problem): string {
  const word = `label.problem_${type?.split("#")[1] ?? ""}`;
  return word in p.en ? p(word as ProblemWord) : (title ?? "");
}
