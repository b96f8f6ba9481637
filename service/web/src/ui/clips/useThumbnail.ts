/** The moving picture of one clip, asked once. */
import { useEffect, useState } from "preact/hooks";
import { address, fetched } from "../../api/client";
import { readThumbnail, type Thumbnail } from "../../motion/loading/thumbnail";

const MOST = 200;
const known = new Map<string, Promise<Thumbnail | null>>();

function thumbnailOf(id: string): Promise<Thumbnail | null> {
  let found = known.get(id);
  if (!found) {
    found = fetched(address("/documents/{id}/thumbnail", { id })).then(
      async (answer) => readThumbnail(new Uint8Array(await answer.arrayBuffer())),
      () => null,
    );
    known.set(id, found);
    if (known.size > MOST) known.delete(known.keys().next().value!);
  }
  return found;
}

export function useThumbnail(id: string): Thumbnail | null {
  const [found, setFound] = useState<Thumbnail | null>(null);
  useEffect(() => {
    let alive = true;
    void thumbnailOf(id).then((one) => alive && setFound(one));
    return () => {
      alive = false;
    };
  }, [id]);
  return found;
}
