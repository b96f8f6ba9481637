/** Choose clips by their names and moving pictures. */
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import type { Schemas } from "../../api/client";
import { w } from "../../words";
import { Dialog } from "../Dialog";
import { Icon } from "../icons";
import { ThumbnailView } from "./ThumbnailView";
import { Trouble } from "../Trouble";
import { useClips } from "./useClips";
import "../../styles/chooser.css";

type KnownRig = Schemas["KnownRigInfo"];

export function ClipChooser({
  label,
  chosen,
  known,
  onKnown,
  onChoose,
}: {
  label: string;
  chosen: string | undefined;
  /** Rigs that can be chosen instead of a clip. */
  known?: readonly KnownRig[];
  onKnown?: (name: KnownRig["name"]) => void;
  onChoose: (id: string) => void;
}) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <button type="button" class="button" onClick={() => setOpen(true)}>
        <span class="dim">{label}:</span> <strong>{chosen ?? w("button.choose")}</strong>
        <Icon name="down" />
      </button>
      {open && (
        <Chooser
          title={label}
          onClose={() => setOpen(false)}
          lead={
            known?.length ? (
              <Rigs
                known={known}
                onChoose={(name) => {
                  setOpen(false);
                  onKnown?.(name);
                }}
              />
            ) : undefined
          }
          onChoose={(id) => {
            setOpen(false);
            onChoose(id);
          }}
        />
      )}
    </>
  );
}

/** Buttons of known rigs. */
function Rigs({ known, onChoose }: { known: readonly KnownRig[]; onChoose: (name: KnownRig["name"]) => void }) {
  return (
    <div class="chooser-rigs">
      <h3>{w("label.knownRigs")}</h3>
      <div class="row wrap">
        {known.map((rig) => (
          <button key={rig.name} type="button" class="button dense" onClick={() => onChoose(rig.name)}>
            {rig.title}
          </button>
        ))}
      </div>
    </div>
  );
}

/** chosen: ids of those that are; the dialog then stays open, and a press takes one in or out. without: not offered. */
export function Chooser({
  title,
  help,
  chosen,
  most = Infinity,
  without,
  lead,
  onClose,
  onChoose,
}: {
  title: string;
  help?: string;
  chosen?: readonly string[];
  most?: number;
  without?: string;
  /** Before the clips. */
  lead?: ComponentChildren;
  onClose: () => void;
  onChoose: (id: string) => void;
}) {
  const [text, setText] = useState("");
  const [hovered, setHovered] = useState("");
  const clips = useClips(text);
  return (
    <Dialog title={title} onClose={onClose} wide>
      {help && <p class="dim chooser-help">{help}</p>}
      {lead}
      <input
        class="field chooser-search"
        type="search"
        autoFocus
        aria-label={w("label.search")}
        placeholder={w("label.search")}
        value={text}
        onInput={(event) => setText(event.currentTarget.value)}
      />
      <Trouble error={clips.error} retry={clips.again} />
      <div class="chooser">
        {(clips.value ?? [])
          .filter((one) => one.id !== without)
          .map((one) => {
            const taken = chosen?.includes(one.id);
            return (
              <button
                key={one.id}
                type="button"
                class="chooser-card"
                aria-pressed={taken}
                disabled={taken === false && chosen!.length >= most}
                onPointerEnter={() => setHovered(one.id)}
                onFocus={() => setHovered(one.id)}
                onClick={() => onChoose(one.id)}
              >
                <ThumbnailView thumbnail={one.thumb} runs={hovered === one.id || Boolean(taken)} label={one.name} />
                <span class="cut block">{one.name}</span>
              </button>
            );
          })}
      </div>
    </Dialog>
  );
}
