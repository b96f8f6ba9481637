import { quoted } from "../../ui/exporting/arrays";

/** A question as a line for scripts. per: each document by itself. values: the answer is no node set. token: the server asks for one,
 * which stands in MCML_TOKEN, where `mcml` finds it. */
export interface Asked {
  q: string;
  project: string;
  form: "runs" | "json";
  per?: boolean;
  /** false: clips with guessed values are left out. */
  guesses?: boolean;
  values?: boolean;
  token?: boolean;
}

export const asCurl = ({ q, project, form, per, guesses = true, token }: Asked, origin: string): string =>
  [
    `curl -G ${origin}/api/v1/xpath${token ? ' -H "Authorization: Bearer $MCML_TOKEN"' : ""} --data-urlencode ${quoted(`q=${q}`)}`,
    ...(project ? [`--data-urlencode ${quoted(`project=${project}`)}`] : []),
    ...(per ? ["-d per=document"] : []),
    ...(guesses ? [] : ["-d guesses=no"]),
    `-d as=${form}`,
  ].join(" ");

/** --server: the store of this page, not the one that the command finds on its own machine. */
export const asCommand = ({ q, project, form, per, guesses = true }: Asked, origin: string): string =>
  [
    `mcml xpath ${quoted(q)}`,
    `--server ${origin}`,
    ...(project ? [`--project ${quoted(project)}`] : []),
    ...(per ? ["--per document"] : []),
    ...(guesses ? [] : ["--guesses no"]),
    `--as ${form}`,
  ].join(" ");

export const asPython = ({ q, project, form, per, guesses = true, values, token }: Asked, origin: string): string => {
  const asked = [
    JSON.stringify(q),
    ...(project ? [`project=${JSON.stringify(project)}`] : []),
    ...(per ? ['per="document"'] : []),
    ...(guesses ? [] : ['guesses="no"']),
  ].join(", ");
  const shown = values
    ? "print(found.value())\n"
    : `for one in found.${form === "runs" ? "runs" : "nodes"}():\n    print(one)\n`;
  return `${token ? "import os\n\n" : ""}import mcml\n\nrepo = mcml.open(${JSON.stringify(origin)}${token ? ', token=os.environ["MCML_TOKEN"]' : ""})\nfound = repo.xpath(${asked})\n${shown}`;
};
