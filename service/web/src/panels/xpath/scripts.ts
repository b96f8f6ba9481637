/** A question as a line for scripts. */
export interface Asked { q: string; project: string; form: "runs" | "json" }

/** As a shell takes it, whatever is in it. */
export const quoted = (text: string): string => `'${text.replaceAll("'", `'\\''`)}'`;

export const asCurl = ({ q, project, form }: Asked, origin: string): string =>
  [`curl -G ${origin}/api/v1/xpath --data-urlencode ${quoted(`q=${q}`)}`, ...(project ? [`--data-urlencode ${quoted(`project=${project}`)}`] : []), `-d as=${form}`].join(" ");

export const asCommand = ({ q, project, form }: Asked): string => [`mcml xpath ${quoted(q)}`, ...(project ? [`--project ${quoted(project)}`] : []), `--as ${form}`].join(" ");

export const asPython = ({ q, project, form }: Asked, origin: string): string =>
  `import mcml\n\nrepo = mcml.open(${JSON.stringify(origin)})\nfound = repo.xpath(${JSON.stringify(q)}${project ? `, project=${JSON.stringify(project)}` : ""})\nfor one in found.${form === "runs" ? "runs" : "nodes"}():\n    print(one)\n`;
