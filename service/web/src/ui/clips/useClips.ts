/** Clips by words, with their moving pictures, for choosing some. */
import { get } from "../../api/client";
import { fromBase64, readThumbnail, type Thumbnail } from "../../motion/loading/thumbnail";
import { duration } from "../../words";
import { useAsync } from "../useAsync";

export interface Found {
  id: string;
  name: string;
  time: string;
  thumb: Thumbnail | null;
}

export function useClips(text: string): ReturnType<typeof useAsync<Found[]>> {
  return useAsync(
    async (signal) => {
      await new Promise((resolve) => setTimeout(resolve, text ? 200 : 0));
      signal.throwIfAborted();
      const answer = await get("/documents", {
        query: { q: text || undefined, limit: 40, sort: "newest", with: "thumbnail" },
        signal,
      });
      return answer.items.map((one) => ({
        id: one.id,
        name: one.name,
        time: duration(one.duration),
        thumb: one.thumbnail ? readThumbnail(fromBase64(one.thumbnail)) : null,
      }));
    },
    [text],
  );
}
