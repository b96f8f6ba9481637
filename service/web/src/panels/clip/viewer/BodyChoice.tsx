/** Which body the viewer shows: the own one, or a character of the library. */
import { useEffect } from "preact/hooks";
import { characterOf, forgetMissing } from "../../../motion/loading/character";
import { characters, chosenCharacter, loadCharacters, nameOfCharacter } from "../../../state/clip/characters";
import type { Clip } from "../../../state/clip/clip";
import { chooseFiles } from "../../../state/importing/uploads";
import { Icon } from "../../../ui/icons";
import { Menu } from "../../../ui/Menu";
import { shown } from "../actions";
import { w } from "../../../words";
import { r } from "../words";

export function BodyChoice({ clip }: { clip: Clip }) {
  useEffect(() => void loadCharacters(), []);
  const chosen = chosenCharacter.value;
  const choose = (id: string) => {
    forgetMissing();
    chosenCharacter.value = id;
    shown.value = { ...shown.peek(), body: true };
  };
  const { id, detail, skeleton } = clip;
  const notes =
    shown.value.body && chosen
      ? (characterOf({ id, revision: detail.revision, skeleton }, chosen).value?.notes ?? [])
      : [];
  const name = chosen && (nameOfCharacter(chosen) ?? r("label.unknownCharacter"));
  return (
    <span class="body-choice" title={notes.join("\n") || undefined} onPointerEnter={() => void loadCharacters()}>
      <Menu
        label={`${r("label.bodyChoice")}: ${name || w("label.ownBody")}`}
        className="button quiet dense"
        items={[
          { text: w("label.ownBody"), checked: !chosen, run: () => choose("") },
          ...characters.value.map((one) => ({
            text: one.name,
            detail: one.project,
            checked: one.document === chosen,
            run: () => choose(one.document),
          })),
          { text: r("button.importCharacter"), icon: "plus" as const, run: chooseFiles },
        ]}
      >
        {name && <span class="body-name">{name}</span>}
        <Icon name="down" />
      </Menu>
    </span>
  );
}
