/** Requests to the repository, typed by its OpenAPI description. Refusals become ApiError with their remedy. */
import type { components, paths } from "./types.gen";

export type Schemas = components["schemas"];
export type Problem = Partial<Schemas["Problem"]> & { remedy?: string | null };

type Method = "get" | "post" | "put" | "patch" | "delete";
type Prefix<P> = P extends `/api/v1${infer Rest}` ? Rest : never;
type Full<P extends string> = `/api/v1${P}`;
export type Path = Prefix<keyof paths & string>;
type Operation<P extends Path, M extends Method> = Full<P> extends keyof paths ? paths[Full<P>][M] : never;
type Json<R> = R extends { content: { "application/json": infer T } } ? T : never;
type Responses<O> = O extends { responses: infer R } ? R : never;
export type Answer<P extends Path, M extends Method> = Json<
  Responses<Operation<P, M>>[keyof Responses<Operation<P, M>> & (200 | 201 | 202)]
>;
type Query<P extends Path, M extends Method> = Operation<P, M> extends { parameters: { query?: infer Q } } ? Q : never;
type Variables<P extends Path, M extends Method> =
  Operation<P, M> extends { parameters: { path: infer V } } ? V : Record<string, never>;
type Body<P extends Path, M extends Method> =
  Operation<P, M> extends { requestBody?: { content: { "application/json": infer B } } } ? B : never;

export interface Options<P extends Path, M extends Method> {
  path?: Variables<P, M>;
  query?: Query<P, M>;
  body?: Body<P, M>;
  /** The revision that was read, for writes to one document. */
  match?: number;
  signal?: AbortSignal;
}

/** What the server refused: what, where and how to mend it, in its words. */
export class ApiError extends Error {
  constructor(
    readonly status: number,
    readonly problem: Problem,
  ) {
    super(problem.detail || problem.title || `${status}`);
  }
  get remedy(): string {
    return this.problem.remedy ?? "";
  }
}

/** No answer came at all. */
export class Offline extends Error {}

const HOME = "/api/v1";
let home = HOME;

/** Ask below another address: as who has a link to some documents. */
export const below = (path: string): void => void (home = path);

export function address(path: string, variables: object = {}, query: object = {}): string {
  const filled = path.replace(/\{(\w+)(?::\w+)?\}/g, (_, name: string) =>
    encodeURIComponent(String((variables as Record<string, unknown>)[name])),
  );
  const search = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    for (const one of Array.isArray(value) ? value : [value]) {
      if (one !== undefined && one !== null && one !== "") search.append(name, String(one));
    }
  }
  const text = search.toString();
  return `${home}${filled}${text ? `?${text}` : ""}`;
}

export async function ask<P extends Path, M extends Method>(
  method: M,
  path: P,
  options: Options<P, M> = {},
): Promise<Answer<P, M>> {
  const headers: Record<string, string> = { accept: "application/json" };
  if (options.body !== undefined) headers["content-type"] = "application/json";
  if (options.match !== undefined) headers["if-match"] = `"${options.match}"`;
  const answer = await fetched(address(path, options.path ?? {}, options.query ?? {}), {
    method: method.toUpperCase(),
    headers,
    body: options.body === undefined ? undefined : JSON.stringify(options.body),
    signal: options.signal,
  });
  return answer.status === 204 ? (undefined as Answer<P, M>) : ((await answer.json()) as Answer<P, M>);
}

export function get<P extends Path>(path: P, options?: Options<P, "get">): Promise<Answer<P, "get">> {
  return ask<P, "get">("get", path, options);
}

/** A response that is no refusal. ApiError and Offline otherwise; an aborted request stays an AbortError. */
export async function fetched(url: string, init: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(url, { credentials: "same-origin", ...init });
  } catch (error) {
    if ((error as Error).name === "AbortError") throw error;
    throw new Offline("The server does not answer.");
  }
  if (answer.ok) return answer;
  if (answer.status === 401 && home === HOME)
    location.assign(`/login?then=${encodeURIComponent(location.pathname + location.search)}`);
  throw new ApiError(answer.status, await problemOf(answer));
}

async function problemOf(answer: Response): Promise<Problem> {
  const kind = answer.headers.get("content-type") ?? "";
  if (kind.includes("json")) return (await answer.json()) as Problem;
  return { title: answer.statusText, detail: `The server answered ${answer.status} without words.` };
}
