/** The moving picture of one clip, asked once. */
import { useEffect, useState } from "preact/hooks";
import { address, fetched } from "../../api/client";
import { readThumbnail, type Thumbnail } from "../../motion/loading/thumbnail";

const MOST = 200;
const known = new Map<string, Promise<Thumbnail | null>>();

/** Frames of a revision, positions from 1, both included. */
export interface Range {
  revision: number;
  first: number;
  last: number;
}

function thumbnailOf(id: string, query: Partial<Range>): Promise<Thumbnail | null> {
  const url = address("/documents/{id}/thumbnail", { id }, query);
  let found = known.get(url);
  if (!found) {
    found = fetched(url).then(
      async (answer) => readThumbnail(new Uint8Array(await answer.arrayBuffer())),
      () => null,
    );
    known.set(url, found);
    if (known.size > MOST) known.delete(known.keys().next().value!);
  }
  return found;
}

/** Of the whole clip, or of a range of it. */
export function useThumbnail(id: string, range?: Range): Thumbnail | null {
  const [found, setFound] = useState<Thumbnail | null>(null);
  const { revision, first, last } = range ?? {};
  useEffect(() => {
    let alive = true;
    void thumbnailOf(id, { revision, first, last }).then((one) => alive && setFound(one));
    return () => {
      alive = false;
    };
  }, [id, revision, first, last]);
  return found;
}
