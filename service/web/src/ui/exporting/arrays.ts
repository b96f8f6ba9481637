/** Frames of many clips as arrays, as lines for scripts of this server. */
import type { Schemas } from "../../api/client";

/** Clips, the frame ranges of a query, or both. */
export interface ArraysSource {
  selection?: { documents?: string[]; project?: string };
  query?: string;
  /** The query leaves out clips that rest on a guess. */
  guesses?: "no";
}
export type ArraysRequest = ArraysSource & Pick<Schemas["ArraysRequest"], "space" | "columns" | "as">;

/** As a shell takes it, whatever is in it. */
export const quoted = (text: string): string => `'${text.replaceAll("'", `'\\''`)}'`;

export const fileName = (request: ArraysRequest): string => `arrays.${request.as}`;

/** token: the server needs one, which stands in MCML_TOKEN. */
export const arraysByCurl = (request: ArraysRequest, origin: string, token: boolean): string =>
  [
    `curl -o ${fileName(request)} ${origin}/api/v1/arrays`,
    ...(token ? ['-H "Authorization: Bearer $MCML_TOKEN"'] : []),
    "-H 'Content-Type: application/json'",
    `-d ${quoted(JSON.stringify(request))}`,
  ].join(" ");

export const arraysByCommand = (request: ArraysRequest, origin: string): string =>
  [
    `mcml arrays ${fileName(request)}`,
    ...(request.selection?.documents ?? []),
    ...(request.selection?.project ? [`--project ${quoted(request.selection.project)}`] : []),
    ...(request.query ? [`--query ${quoted(request.query)}`] : []),
    ...(request.guesses ? ["--guesses no"] : []),
    `--space ${request.space}`,
    ...(request.columns === "shared" ? ["--columns shared"] : []),
    `--server ${origin}`,
  ].join(" ");

export const arraysByPython = (request: ArraysRequest, origin: string, token: boolean): string => {
  const asked = [
    ...(request.selection?.documents?.length ? [`documents=${JSON.stringify(request.selection.documents)}`] : []),
    ...(request.selection?.project ? [`project=${JSON.stringify(request.selection.project)}`] : []),
    ...(request.query ? [`query=${JSON.stringify(request.query)}`] : []),
    ...(request.guesses ? ['guesses="no"'] : []),
    `space=${JSON.stringify(request.space)}`,
    ...(request.columns === "shared" ? ['columns="shared"'] : []),
  ].join(", ");
  const opened = `mcml.open(${JSON.stringify(origin)}${token ? ', token=os.environ["MCML_TOKEN"]' : ""})`;
  return [
    ...(token ? ["import os", ""] : []),
    "import mcml",
    "",
    `repo = ${opened}`,
    `arrays = repo.arrays(${asked})`,
    "print(arrays.values.shape, arrays.columns)",
    "for name, values in zip(arrays.names, arrays):",
    "    print(name, values.shape)",
    "",
  ].join("\n");
};
