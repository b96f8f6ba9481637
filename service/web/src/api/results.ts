/** Results of analyses: their parts, arrays as numbers, and what can be done with them. A result never changes. */
import { readNpy, type NdArray } from "../motion/loading/npy";
import { address, fetched, get, type Schemas } from "./client";

export type Result = Schemas["Result"];
export type Part = Schemas["PartSummary"];
export type MotionHead = Omit<Schemas["PreviewMotion"], "data">;

/** What an operation answered: its value, and the motion that it made. */
export interface Done<T> {
  value: T;
  /** Where the clip was stored, where what was made was kept. */
  document?: string;
  result?: string;
}
export interface Made<T> extends Done<T> {
  motion: MotionHead;
  /** (frames, points, 3), told from the origin of the motion. */
  positions: Float32Array;
}
export interface Saving {
  save?: boolean;
  name?: string;
  project?: string;
}

export const resultOf = (id: string, signal?: AbortSignal): Promise<Result> =>
  get("/results/{id}", { path: { id }, signal });

/** An array of a part, whole or some of its rows. `single`: as f4. */
export async function arrayOf(
  id: string,
  part: string,
  array: string,
  { rows, single, signal }: { rows?: number[]; single?: boolean; signal?: AbortSignal } = {},
): Promise<NdArray> {
  const query = { format: "npy", dtype: single ? "f4" : undefined, row: rows };
  const answer = await fetched(address("/results/{id}/{part}/{array}", { id, part, array }, query), { signal });
  return readNpy(await answer.arrayBuffer());
}

const asked = (
  id: string,
  operation: string,
  parameters: object,
  saving: Saving,
  query: object,
  signal?: AbortSignal,
) =>
  fetched(address("/results/{id}/{operation}", { id, operation }, query), {
    method: "POST",
    signal,
    headers: { "content-type": "application/json" },
    body: JSON.stringify({ parameters, ...saving }),
  });

/** A part of a result. RangeError where the result has none of this name. */
export function partOf(result: Result, name: string): NonNullable<Result["parts"]>[string] {
  const part = result.parts[name];
  if (!part) throw new RangeError(`The result ${result.id} has no part ${name}.`);
  return part;
}

/** Do something with a result; T is the value that its operation answers. */
export async function applyResult<T>(
  id: string,
  operation: string,
  parameters: object,
  saving: Saving = {},
  signal?: AbortSignal,
): Promise<Done<T>> {
  return (await (await asked(id, operation, parameters, saving, {}, signal)).json()) as Done<T>;
}

/** As applyResult, with the motion that it makes as positions: for what follows a slider. */
export async function makeMotion<T>(
  id: string,
  operation: string,
  parameters: object,
  saving: Saving = {},
  signal?: AbortSignal,
): Promise<Made<T>> {
  const answer = await asked(id, operation, parameters, saving, { format: "block" }, signal);
  return readBlock(await answer.arrayBuffer());
}

/** JSON and positions of one answer (docs/api/analyses.md). */
export function readBlock<T>(buffer: ArrayBuffer): Made<T> {
  const size = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size))) as Omit<Made<T>, "positions">;
  return { ...head, positions: new Float32Array(buffer, 4 + size) };
}

/** The rows of a table part, each by the names of its columns. */
export function rowsOf<T = Record<string, unknown>>(part: Part | undefined): T[] {
  const columns = ((part?.data.columns ?? []) as { name: string }[]).map((one) => one.name);
  return ((part?.data.rows ?? []) as unknown[][]).map(
    (row) => Object.fromEntries(columns.map((name, at) => [name, row[at]])) as T,
  );
}
