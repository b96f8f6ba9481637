/** Make a project of the file that an export gave: chosen or dropped, named, watched, told. */
import { useEffect, useRef, useState } from "preact/hooks";
import type { Schemas } from "../../api/client";
import { dropHere } from "../../state/importing/drop";
import { note } from "../../state/session/notes";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { number, w } from "../../words";
import { send } from "./sending";
import { size } from "./sizes";
import { s } from "./words";

type Made = Schemas["ProjectImported"];

export function ImportProject({ onDone }: { onDone: (project: string) => void }) {
  const [file, setFile] = useState<File | null>(null);
  const [name, setName] = useState("");
  const [sent, setSent] = useState<number | null>(null);
  const [trouble, setTrouble] = useState<unknown>(null);
  const [made, setMade] = useState<Made | null>(null);
  const going = useRef<AbortController | null>(null);
  const input = useRef<HTMLInputElement>(null);
  const take = (files: File[]) => {
    if (!files[0] || going.current) return;
    if (files.length > 1 || !/\.zip$/i.test(files[0].name)) {
      note(s("help.oneFile"), { bad: true });
      return;
    }
    setFile(files[0]);
    setName("");
    setTrouble(null);
    setMade(null);
  };
  useEffect(() => {
    dropHere.value = { title: s("label.dropProject"), help: s("help.dropProjectHelp"), take };
    return () => void (dropHere.value = null);
  }, []);
  // Who leaves the page hears nothing of it any more: what is not sent yet is not sent.
  useEffect(() => () => going.current?.abort(), []);
  const start = async () => {
    const form = new FormData();
    if (name.trim()) form.append("name", name.trim());
    form.append("file", file!, file!.name);
    going.current = new AbortController();
    setTrouble(null);
    setSent(0);
    try {
      const answer = await send<Made>("/projects", form, setSent, going.current.signal);
      setMade(answer);
      setFile(null);
      onDone(answer.project);
    } catch (error) {
      if ((error as Error).name !== "AbortError") setTrouble(error);
    } finally {
      going.current = null;
      setSent(null);
    }
  };
  return (
    <section>
      <h3>{s("button.importTitle")}</h3>
      <p class="dim">{s("help.importHelp")}</p>
      <input
        ref={input}
        type="file"
        hidden
        accept=".zip"
        aria-label={s("button.chooseFile")}
        onChange={(event) => {
          take([...(event.currentTarget.files ?? [])]);
          event.currentTarget.value = "";
        }}
      />
      {made && (
        <p class="row wrap import-made" role="status">
          <Icon name="check" />
          <span>{s("label.imported", { name: made.project, n: made.documents })}</span>
          <a href={`/library?project=${encodeURIComponent(made.project)}`}>{s("button.openClips")}</a>
        </p>
      )}
      {file ? (
        <form
          class="import-file"
          onSubmit={(event) => {
            event.preventDefault();
            void start();
          }}
        >
          <p class="row wrap">
            <strong class="cut">{file.name}</strong>
            <span class="dim">{size(file.size)}</span>
          </p>
          <p class="row wrap">
            <input
              class="field grow"
              aria-label={s("label.importName")}
              placeholder={s("label.importName")}
              maxLength={256}
              disabled={sent !== null}
              value={name}
              onInput={(event) => setName(event.currentTarget.value)}
            />
            {sent === null && (
              <button type="submit" class="button primary">
                {s("button.importIt")}
              </button>
            )}
            <button
              type="button"
              class="button"
              onClick={() => (going.current ? going.current.abort() : setFile(null))}
            >
              {w("button.cancel")}
            </button>
          </p>
          {sent !== null && (
            <p class="row">
              <progress
                class="grow"
                max={1}
                value={sent === 1 ? undefined : sent}
                aria-label={s("button.importTitle")}
              />
              <span class="dim" role="status">
                {sent === 1
                  ? s("label.importReading")
                  : s("label.importSending", { share: number(Math.floor(sent * 100)) })}
              </span>
            </p>
          )}
          <Trouble error={trouble} />
        </form>
      ) : (
        <p>
          <button type="button" class="button" onClick={() => input.current?.click()}>
            <Icon name="upload" />
            {s("button.chooseFile")}
          </button>
        </p>
      )}
    </section>
  );
}
