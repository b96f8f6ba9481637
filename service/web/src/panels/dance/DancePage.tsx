import { w } from "../../words";

export function DancePage({ id }: { id: string }) {
  return <div class="empty"><h1>{w("dance")}</h1><p>{id}</p></div>;
}
