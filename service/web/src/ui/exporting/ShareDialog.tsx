/** A link by which somebody without an account sees some clips. */
import { useState } from "preact/hooks";
import { ask, type Schemas } from "../../api/client";
import { writtenFormats } from "../../state/session/formats";
import { note, refuse } from "../../state/session/notes";
import { w } from "../../words";
import { Dialog } from "../Dialog";
import "../../styles/shared.css";

const CSV = { name: "csv", label: "CSV" };

export function ShareDialog({ ids, onClose }: { ids: string[]; onClose: () => void }) {
  const [given, setGiven] = useState({ name: "", days: 14, latest: true });
  const [formats, setFormats] = useState<Schemas["ShareRequest"]["formats"]>([]);
  const [link, setLink] = useState("");
  const make = async (event: Event) => {
    event.preventDefault();
    try {
      const made = await ask("post", "/shares", { body: { ...given, documents: ids, formats } });
      setLink(location.origin + made.path);
    } catch (error) {
      refuse(error);
    }
  };
  const copy = async () => {
    await navigator.clipboard.writeText(link);
    note(w("label.copied"));
  };
  const choose = (format: string, on: boolean) =>
    setFormats((formats ?? []).filter((one) => one !== format).concat(on ? [format] : []));
  if (link) {
    return (
      <Dialog title={w("button.shareLink")} onClose={onClose}>
        <div class="share-form">
          <p>{w("help.shareMade")}</p>
          <code class="share-link">{link}</code>
          <p class="row">
            <button type="button" class="button primary" onClick={() => void copy()}>
              {w("button.copy")}
            </button>
            <a class="button" href={link} target="_blank" rel="noreferrer">
              {w("button.open")}
            </a>
          </p>
        </div>
      </Dialog>
    );
  }
  return (
    <Dialog title={w("button.shareLink")} onClose={onClose}>
      <form class="share-form" onSubmit={(event) => void make(event)}>
        <p class="dim">{w("help.shareHelp", { n: ids.length })}</p>
        <label>
          {w("label.shareFor")}{" "}
          <input
            class="field"
            required
            maxLength={256}
            value={given.name}
            onInput={(event) => setGiven({ ...given, name: event.currentTarget.value })}
          />
        </label>
        <label>
          {w("label.shareDays")}{" "}
          <input
            class="field"
            type="number"
            min={1}
            max={365}
            value={given.days}
            onInput={(event) => setGiven({ ...given, days: Number(event.currentTarget.value) })}
          />
        </label>
        <label class="row">
          <input
            type="checkbox"
            checked={given.latest}
            onChange={(event) => setGiven({ ...given, latest: event.currentTarget.checked })}
          />{" "}
          {w("label.shareLatest")}
        </label>
        <fieldset>
          <legend>{w("label.shareFormats")}</legend>
          <div class="checks">
            {[...writtenFormats(), CSV].map(({ name, label }) => (
              <label key={name} class="row">
                <input
                  type="checkbox"
                  checked={formats?.includes(name)}
                  onChange={(event) => choose(name, event.currentTarget.checked)}
                />{" "}
                {label}
              </label>
            ))}
          </div>
        </fieldset>
        <p class="row">
          <button class="button primary">{w("button.makeLink")}</button>
        </p>
      </form>
    </Dialog>
  );
}
