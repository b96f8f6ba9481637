import type { Clip } from "../../state/clip";
export function TextView({ clip }: { clip: Clip; reload: () => void }) { return <div>{clip.id}</div>; }
