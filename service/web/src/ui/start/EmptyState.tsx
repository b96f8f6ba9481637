/** A page before its first material: one picture, one sentence that says what the page makes, and ways to begin. */
import type { ComponentChildren } from "preact";
import { useEffect, useState } from "preact/hooks";
import { chooseFiles } from "../../state/importing/uploads";
import { askWhetherEmpty, demoProgress, isEmpty, loadDemo, type DemoPart } from "../../state/library/demo";
import { archives, readFormats } from "../../state/session/formats";
import { askMe, mayEdit } from "../../state/session/me";
import { refuse } from "../../state/session/notes";
import { w } from "../../words";
import { Icon } from "../icons";
import { Picture, type PictureName } from "./Picture";
import "../../styles/start.css";

interface Props {
  picture: PictureName;
  /** The heading; without it, the page has one. */
  title?: string;
  /** One sentence: what the page makes. */
  makes: string;
  /** What it needs, as a hint. */
  needs?: string;
  /** What the clips of this library lack, where they do. */
  missing?: string;
  /** Parts of the demo library that the page shows. */
  parts: readonly DemoPart[];
  /** Shows the demo clips, once they are stored. */
  onDemo?: () => unknown;
  busy?: boolean;
  children?: ComponentChildren;
}

/** Whether the whole repository has no clips: pages then show nothing else. Null until it is known. */
export function useIsEmpty(): boolean | null {
  useEffect(() => {
    if (!isEmpty.peek()) void askWhetherEmpty();
  }, []);
  return isEmpty.value;
}

export function EmptyState({ picture, title, makes, needs, missing, parts, onDemo, busy, children }: Props) {
  const [trying, setTrying] = useState(false);
  useEffect(() => void askMe(), []);
  const tryDemo = async () => {
    setTrying(true);
    try {
      if (mayEdit()) await loadDemo(parts);
      await onDemo?.();
    } catch (error) {
      refuse(error);
    } finally {
      setTrying(false);
    }
  };
  const empty = useIsEmpty();
  return (
    <div class="empty-state">
      <Picture name={picture} />
      {title && <h2>{title}</h2>}
      <p class="empty-makes">{makes}</p>
      {missing && !empty && (
        <p class="empty-missing" role="note">
          {missing}
        </p>
      )}
      {needs && !empty && <p class="dim">{needs}</p>}
      {(mayEdit() || !empty) && (
        <p class="row wrap">
          <button
            type="button"
            class="button primary"
            disabled={trying || demoProgress.value !== null || busy}
            onClick={() => void tryDemo()}
          >
            {w("button.tryDemo")}
          </button>
          {mayEdit() && (
            <button type="button" class="button" onClick={() => chooseFiles()}>
              <Icon name="upload" />
              {w("button.importFiles")}
            </button>
          )}
        </p>
      )}
      <DemoProgress />
      {children}
      {mayEdit() && <Formats />}
    </div>
  );
}

/** How far the demo clips are, while they are loaded. */
export function DemoProgress({ hidden = false }: { hidden?: boolean }) {
  const now = demoProgress.value;
  if (!now || hidden) return null;
  const parts = now.all > 1;
  return (
    <p class="row empty-progress">
      <progress max={now.all} value={parts ? now.done : undefined} aria-label={w("label.demoLoading")} />
      <span role="status" class="dim">
        {parts ? w("label.demoPart", { now: now.done + 1, all: now.all }) : w("label.demoLoading")}
      </span>
    </p>
  );
}

function Formats() {
  const read = readFormats();
  if (!read.length) return null;
  return (
    <div class="empty-formats">
      <p class="dim" id="formats-read">
        {w("label.formatsRead")}
      </p>
      <ul aria-labelledby="formats-read">
        {read.map((one) => (
          <li key={one.name} title={one.title}>
            {one.label}
          </li>
        ))}
        {archives.map((one) => (
          <li key={one}>{one}</li>
        ))}
      </ul>
    </div>
  );
}
