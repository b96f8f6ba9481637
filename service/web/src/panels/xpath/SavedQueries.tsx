import { saved } from "../../state/saved";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { w } from "../../words";

export function SavedQueries({ text, onChoose }: { text: string; onChoose: (query: string) => void }) {
  const keep = () => { if (text.trim()) saved.value = [...saved.peek().filter((one) => one !== text.trim()), text.trim()]; };
  return (
    <Menu label={w("savedQueries")} className="button quiet" side="right" items={[
      { text: w("saveQuery"), icon: "plus", disabled: !text.trim(), run: keep },
      ...saved.value.map((one) => ({ text: one.length > 70 ? `${one.slice(0, 70)}…` : one, run: () => onChoose(one) })),
    ]}>{w("savedQueries")}<Icon name="down" /></Menu>
  );
}
