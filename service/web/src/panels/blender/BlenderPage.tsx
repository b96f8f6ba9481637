import { w } from "../../words";

export function BlenderPage({ id }: { id: string }) {
  return <div class="empty"><h1>{w("blender")}</h1><p>{id}</p></div>;
}
