import { w } from "../../words";

export function FacesPage({ id }: { id: string }) {
  return <div class="empty"><h1>{w("faces")}</h1><p>{id}</p></div>;
}
