/** Angular speeds of all clips of a model, end to end as they are stored. */
import { numberAt } from "../../lists";
import { partOf, arrayOf, type Result } from "../../api/results";

export class Speeds {
  private readonly place: Map<string, number>;
  constructor(
    documents: string[],
    private readonly speed: ArrayLike<number> & { subarray(from: number, to: number): ArrayLike<number> },
    private readonly first: ArrayLike<number>,
  ) {
    this.place = new Map(documents.map((one, at) => [one, at]));
  }

  /** Of one clip, a value a frame. */
  of(document: string): ArrayLike<number> | null {
    const at = this.place.get(document);
    return at === undefined ? null : this.speed.subarray(numberAt(this.first, at), numberAt(this.first, at + 1));
  }
}

export async function speedsOf(result: Result, signal?: AbortSignal): Promise<Speeds> {
  const [speed, first] = await Promise.all([
    arrayOf(result.id, "speed", "speed", { single: true, signal }),
    arrayOf(result.id, "speed", "first", { signal }),
  ]);
  return new Speeds(partOf(result, "speed").data.documents as string[], speed.values, first.values);
}
