/** The import: a table by file name while files go and once they are there; one line of it as soon as another thing is done. */
import { useEffect, useRef, useState } from "preact/hooks";
import { looked } from "../../../state/importing/inspect";
import { timeLeft } from "../../../state/importing/pace";
import { countOutcomes, OUTCOMES, reportOf, storedIn, type Line, type Outcome } from "../../../state/importing/report";
import { cancelAll, filesDone, pace, trayOpen, uploads } from "../../../state/importing/uploads";
import { picked } from "../../../state/library/library";
import { go, page, route } from "../../../state/session/route";
import { Icon } from "../../../ui/icons";
import { number, w } from "../../../words";
import { i } from "../words";
import { CopyReport } from "./CopyReport";
import { InspectedFiles } from "./InspectedFiles";
import { ReportTable } from "./ReportTable";
import { useFold } from "./useFold";
import "../../../styles/importing.css";

export function UploadTray() {
  return (
    <>
      {looked.value && <InspectedFiles of={looked.value} />}
      {uploads.value.length > 0 && <Tray />}
    </>
  );
}

function Tray() {
  const box = useRef<HTMLElement>(null);
  const [only, setOnly] = useState<Outcome | null>(null);
  const { page: where, id } = route.value;
  const place = useRef(`${where}/${id}`);
  const lines = reportOf(uploads.value);
  const counts = countOutcomes(lines);
  const isDone = !counts.has("underway");
  useFold(box);
  useEffect(() => {
    if (place.current !== `${where}/${id}`) trayOpen.value = false;
    place.current = `${where}/${id}`;
  }, [where, id]);
  const chosen = only && counts.has(only) ? only : null;
  return (
    <section ref={box} class={`tray ${trayOpen.value ? "open" : "folded"}`} aria-label={w("button.queue")}>
      <TrayHeader counts={counts} isDone={isDone} />
      {trayOpen.value && (
        <>
          <div class="row report-tools">
            <Filters counts={counts} all={lines.length} only={chosen} onOnly={setOnly} />
            <span class="grow" />
            {isDone && <SelectAll lines={lines} />}
            {isDone && <CopyReport lines={lines} />}
          </div>
          <ReportTable
            lines={chosen ? lines.filter((one) => one.outcome === chosen) : lines}
            alone={lines.length === 1}
          />
        </>
      )}
    </section>
  );
}

function TrayHeader({ counts, isDone }: { counts: Map<Outcome, number>; isDone: boolean }) {
  const { done, of } = filesDone(uploads.value);
  return (
    <header class="row">
      <strong>{w("button.queue")}</strong>
      {of > 1 && <span class="dim pace">{progressOf(done, of)}</span>}
      {/* What changes twice a second is not announced. */}
      <span class="unseen" role="status">
        {isDone && w("label.uploads", { done, n: of })}
      </span>
      {isDone ? (
        <Counted counts={counts} />
      ) : (
        <progress class="grow" value={done} max={of} aria-label={w("button.queue")} />
      )}
      {!isDone && (
        <button type="button" class="button dense" onClick={cancelAll}>
          {w("button.cancel")}
        </button>
      )}
      <button
        type="button"
        class="button dense"
        aria-expanded={trayOpen.value}
        onClick={() => (trayOpen.value = !trayOpen.peek())}
      >
        {i(trayOpen.value ? "button.hideReport" : "button.showReport")}
      </button>
      {isDone && (
        <button
          type="button"
          class="button quiet icon dense"
          aria-label={w("button.hideQueue")}
          onClick={() => (uploads.value = [])}
        >
          <Icon name="close" />
        </button>
      )}
    </header>
  );
}

/** Lines by outcome in one sentence: "5 imported · 1 failed". */
function Counted({ counts }: { counts: Map<Outcome, number> }) {
  return (
    <span class="dim cut grow">
      {OUTCOMES.filter((one) => counts.has(one))
        .map((one) => `${number(counts.get(one) ?? 0)} ${i(`label.${one}`)}`)
        .join(" · ")}
    </span>
  );
}

function Filters({
  counts,
  all,
  only,
  onOnly,
}: {
  counts: Map<Outcome, number>;
  all: number;
  only: Outcome | null;
  onOnly: (outcome: Outcome | null) => void;
}) {
  const present = OUTCOMES.filter((one) => counts.has(one));
  if (present.length < 2) return null;
  const button = (outcome: Outcome | null, text: string, n: number) => (
    <button key={text} type="button" class="chip" aria-pressed={only === outcome} onClick={() => onOnly(outcome)}>
      {text} <span class="count">{number(n)}</span>
    </button>
  );
  return (
    <div class="row report-filters" role="group" aria-label={i("label.outcome")}>
      {button(null, i("label.all"), all)}
      {present.map((one) => button(one, i(`label.${one}`), counts.get(one) ?? 0))}
    </div>
  );
}

function SelectAll({ lines }: { lines: Line[] }) {
  const ids = storedIn(lines);
  if (!ids.length) return null;
  return (
    <button
      type="button"
      class="button dense"
      onClick={() => {
        picked.value = new Set(ids);
        trayOpen.value = false;
        if (page.peek() !== "library") go("/library");
      }}
    >
      {i("button.selectImported", { n: ids.length })}
    </button>
  );
}

function progressOf(done: number, of: number): string {
  const told = done < of ? pace.value : null;
  if (!told) return w("label.uploads", { done, n: of });
  const { rate, left } = told;
  const speed =
    rate >= 10
      ? w("label.filesASecond", { n: Math.round(rate) })
      : rate >= 0.1
        ? w("label.filesASecond", { n: Math.round(10 * rate) / 10 })
        : w("label.filesAMinute", { n: Math.round(600 * rate) / 10 });
  return w("label.uploadsPace", { done, of, speed, left: timeLeft(left) });
}
