/** The card that is looked at, large, with its passport and what can be done with it. */
import { nameColour } from "../../motion/timeline/colours";
import * as library from "../../state/library/library";
import { mayEdit } from "../../state/session/me";
import { confirmFact } from "../../state/importing/uploads";
import { go } from "../../state/session/route";
import { Icon } from "../../ui/icons";
import { Menu } from "../../ui/Menu";
import { ThumbnailView } from "../../ui/clips/ThumbnailView";
import { duration, number, rate, w, when } from "../../words";
import { exportItems } from "../../ui/exporting/exports";

export function Preview() {
  void library.version.value;
  const id = library.current.value;
  const card = id ? library.cardOf(id) : library.cardAt(0);
  if (!card) return null;
  const { passport } = card;
  const guessed = new Set(passport?.guessed ?? []);
  const names = [...new Set(card.labels.map((label) => label.name))];
  const fact = (word: "unit" | "up", value: string | null | undefined) => (
    <dd>
      <span class={guessed.has(word) ? "guess" : ""}>
        {value ?? w(word === "unit" ? "label.unitUnknown" : "label.upUnknown")}
      </span>
      {guessed.has(word) && value && !value.includes("/") && (
        <button type="button" class="button quiet dense" onClick={() => void confirmFact([card.id], { [word]: value })}>
          {w("button.confirm")}
        </button>
      )}
    </dd>
  );
  return (
    <>
      <div class="preview-figure">
        <ThumbnailView thumbnail={card.thumb} runs label={card.name} />
      </div>
      <div>
        <h2 class="cut" title={card.name}>
          {card.name}
        </h2>
        <p class="dim">
          {[card.project, w("label.revision", { n: card.revision }), when(card.modified)].filter(Boolean).join(" · ")}
        </p>
      </div>
      <dl class="facts">
        <dt>{w("label.unit")}</dt>
        {fact("unit", passport?.unit)}
        <dt>{w("label.rateWord")}</dt>
        <dd>
          <span class={guessed.has("rate") ? "guess" : ""}>{rate(card.seconds_per_frame)}</span>
        </dd>
        <dt>{w("label.up")}</dt>
        {fact("up", passport?.up)}
        <dt>{w("label.joints")}</dt>
        <dd>{passport ? number(passport.joints) : "–"}</dd>
        <dt>{w("label.length")}</dt>
        <dd>
          {w("label.framesAndTime", { frames: w("label.frames", { n: card.frames }), time: duration(card.duration) })}
        </dd>
        {names.length > 0 && (
          <>
            <dt>{w("label.names")}</dt>
            <dd>
              {names.map((name) => (
                <span key={name} class="name-chip">
                  <span class="swatch" style={{ background: nameColour(name) }} />
                  {name}
                </span>
              ))}
            </dd>
          </>
        )}
      </dl>
      <div class="row wrap">
        <a class="button primary" href={`/clips/${card.id}`}>
          {w("button.open")}
        </a>
        <Menu
          label={w("button.exportWord")}
          items={() =>
            exportItems(
              {
                id: card.id,
                markers: passport?.markers ?? false,
                original: true,
                format: card.format,
                hasRate: Boolean(card.seconds_per_frame),
                ...(["unit", "up"] as const).reduce(
                  (all, name) => ({
                    ...all,
                    [name]: guessed.has(name) ? null : (passport?.[name] ?? null),
                    [name === "unit" ? "likelyUnit" : "likelyUp"]: passport?.[name],
                  }),
                  { unit: null, up: null },
                ),
              },
              mayEdit()
                ? { accept: (fact) => void confirmFact([card.id], fact), give: () => go(`/clips/${card.id}?tab=info`) }
                : {},
            )
          }
        >
          {w("button.exportWord")}
          <Icon name="down" />
        </Menu>
        <button type="button" class="button" onClick={() => go(`/compose?s=${card.id}`)}>
          {w("button.composeThese")}
        </button>
      </div>
    </>
  );
}
