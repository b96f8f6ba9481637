/** What comes in: each file's progress, and its receipt in plain words with what was guessed to be confirmed. */
import { itemAt } from "../../lists";
import { useState } from "preact/hooks";
import { looked } from "../../state/importing/inspect";
import { timeLeft } from "../../state/importing/pace";
import {
  addFiles,
  cancel,
  cancelAll,
  confirmFact,
  filesDone,
  pace,
  retry,
  trayOpen,
  undoImport,
  uploads,
  type Upload,
} from "../../state/importing/uploads";
import { folderOf } from "../../state/importing/dropped";
import { FACTS, ORIGINS, shownValue, type Fact } from "../../motion/body/calibration";
import type { Told } from "../../motion/loading/preview";
import { lazy } from "../../ui/lazy";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import { get, type Problem, type Schemas } from "../../api/client";

type Receipt = Schemas["Receipt"];

/** A joint whose name is less sure is a guess. */
const DOUBTFUL = 0.7;

const LookedMotion = lazy(async () => (await import("./LookedMotion")).LookedMotion);

export function UploadTray() {
  const all = uploads.value;
  const { done, of } = filesDone(all);
  return (
    <>
      {looked.value && <LookedAt />}
      {trayOpen.value && all.length > 0 && (
        <section class="tray" aria-label={w("button.queue")}>
          <header class="row">
            <strong>{w("button.queue")}</strong>
            {of > 1 && <span class="dim pace">{progressOf(done, of)}</span>}
            {/* What changes twice a second is not announced. */}
            <span class="unseen" role="status">
              {done === of && w("label.uploads", { done, n: of })}
            </span>
            <progress class="grow" value={done} max={of} aria-label={w("button.queue")} />
            {done < of && (
              <button type="button" class="button dense" onClick={cancelAll}>
                {w("button.cancel")}
              </button>
            )}
            <button
              type="button"
              class="button quiet icon dense"
              aria-label={w("button.hideQueue")}
              onClick={() => {
                trayOpen.value = false;
                if (done === of) uploads.value = [];
              }}
            >
              <Icon name="close" />
            </button>
          </header>
          <UploadRows all={all} />
        </section>
      )}
    </>
  );
}

const ROWS = 200;

/** The newest first; refusals before what went well once all is done. */
function UploadRows({ all }: { all: Upload[] }) {
  const [most, setMost] = useState(ROWS);
  const newest = all.slice().reverse();
  const rows = newest.every((one) => /stored|refused|cancelled/.test(one.state))
    ? [...newest.filter((one) => one.problems.length), ...newest.filter((one) => !one.problems.length)]
    : newest;
  return (
    <ul>
      {rows.slice(0, most).map((one) => (
        <UploadRow key={one.id} upload={one} alone={all.length === 1} />
      ))}
      {rows.length > most && (
        <li>
          <button type="button" class="button dense" onClick={() => setMost(most + ROWS)}>
            {w("button.rowsMore", { n: rows.length - most })}
          </button>
        </li>
      )}
    </ul>
  );
}

/** What became of a row: also where some of its files were stored and others not. */
function stateOf({ state, documents, problems }: Upload): string {
  if (state !== "stored") return w(`label.${state}`);
  if (problems.length) return w("label.storedPartly", { stored: documents.length, refused: problems.length });
  return documents.every((one) => one.skipped) ? w("label.skippedTwin") : w("label.stored");
}

const FEW = 3;

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

function UploadRow({ upload, alone }: { upload: Upload; alone: boolean }) {
  const [open, setOpen] = useState(alone);
  const { files, documents } = upload;
  const first = documents[0];
  const folder = files.length ? folderOf(files[0]!) : "";
  const name = files.length > FEW ? w("label.filesAnd", { name: files[0]!.name, n: files.length - 1 }) : upload.name;
  const hasTwin = documents.some((one) => !one.skipped && one.receipt.twins.length > 0);
  return (
    <li>
      <div class="row">
        <span class={`state ${upload.state}`}>
          {upload.state === "stored" ? <Icon name="check" /> : upload.state === "refused" ? <Icon name="warn" /> : null}
        </span>
        <span class="cut grow" title={folder + upload.name}>
          {name} {folder && <span class="dim">{folder}</span>}
        </span>
        {hasTwin && <span class="dim">{w("help.twin")}</span>}
        {upload.state === "sending" ? (
          <progress value={upload.sent} max={1} aria-label={upload.name} />
        ) : (
          <span class="dim">{stateOf(upload)}</span>
        )}
        {/queued|sending|reading/.test(upload.state) && (
          <button
            type="button"
            class="button quiet icon dense"
            aria-label={w("button.cancel")}
            onClick={() => cancel(upload.id)}
          >
            <Icon name="close" />
          </button>
        )}
        {files.length > 0 && /refused|cancelled/.test(upload.state) && (
          <button type="button" class="button dense" onClick={() => retry(upload.id)}>
            {w("button.retry")}
          </button>
        )}
        {documents.length === 1 && (
          <a class="button dense" href={`/clips/${first!.id}`}>
            {w("button.open")}
          </a>
        )}
        {first && (
          <button type="button" class="button quiet dense" aria-expanded={open} onClick={() => setOpen(!open)}>
            {w("label.receipts")}
          </button>
        )}
      </div>
      {upload.problems.map(({ file, problem }, at) => (
        <Refusal key={at} file={file} problem={problem} />
      ))}
      {documents.length > 1 && (
        <ul class="stored-clips">
          {documents.map((one) => (
            <li key={one.id}>
              <a href={`/clips/${one.id}`}>{one.name}</a>{" "}
              <span class="dim">{w(one.skipped ? "label.skippedTwin" : "label.stored")}</span>
            </li>
          ))}
        </ul>
      )}
      {open && documents.map((one) => <ReceiptView key={one.id} receipt={one.receipt} documents={[one.id]} />)}
      {open && first && !first.skipped && (
        <p>
          <button type="button" class="button dense" onClick={() => void undoImport(upload)}>
            {w("button.undoImport")}
          </button>
        </p>
      )}
    </li>
  );
}

function Refusal({ file, problem }: { file: string; problem: Problem }) {
  const place = [problem.where?.line && w("label.line", { n: problem.where.line }), problem.where?.element]
    .filter(Boolean)
    .join(", ");
  return (
    <div class="refusal">
      <strong>{problem.title}</strong> <span class="dim">{[file, place].filter(Boolean).join(", ")}</span>
      {problem.detail !== problem.title && <p>{problem.detail}</p>}
      {problem.remedy && <p>{problem.remedy}</p>}
    </div>
  );
}

const UNITS = ["cm", "mm", "m", "inch"];
const AXES = ["Y", "Z"];

/** What an import found, guessed and mended. documents: where answers are written; none: nothing is stored. */
export function ReceiptView({ receipt, documents }: { receipt: Receipt; documents: string[] }) {
  const [said, setSaid] = useState<{ unit?: string; up?: string }>({});
  const choose = async (change: { unit?: string; up?: string }) => {
    if (await confirmFact(documents, change)) setSaid({ ...said, ...change });
  };
  const fact = (
    name: "unit" | "up",
    one: { value?: string | null; stated: boolean; why: string },
    options: string[],
  ) => {
    const value = said[name] ?? one.value;
    return (
      <>
        <dd>
          {value ? (
            <span class={one.stated || said[name] ? "" : "guess"}>{value}</span>
          ) : (
            <span class="guess">{w(name === "unit" ? "label.unitUnknown" : "label.upUnknown")}</span>
          )}{" "}
          <span class="dim">{one.why}</span>
        </dd>
        <dd class="row">
          {!one.stated &&
            !said[name] &&
            documents.length > 0 &&
            options.map((option) => (
              <button key={option} type="button" class="button dense" onClick={() => void choose({ [name]: option })}>
                {option}
              </button>
            ))}
          {(one.stated || said[name]) && <Icon name="check" />}
        </dd>
      </>
    );
  };
  const { naming } = receipt;
  return (
    <dl class="receipt">
      <dt>{w("label.receiptUnit")}</dt>
      {fact("unit", receipt.unit, UNITS)}
      <dt>{w("label.receiptRate")}</dt>
      <dd>
        {receipt.frame_rate.frames_per_second
          ? `${number(receipt.frame_rate.frames_per_second, 4)} Hz`
          : w("label.rateUnknown")}{" "}
        <span class="dim">{receipt.frame_rate.why}</span>
      </dd>
      <dd>{receipt.frame_rate.stated && <Icon name="check" />}</dd>
      <dt>{w("label.receiptUp")}</dt>
      {fact("up", receipt.up_axis, AXES)}
      {documents.length > 0 && <CalibrationRow id={itemAt(documents, 0)} said={said} />}
      {naming && (
        <>
          <dt>{w("label.receiptJoints")}</dt>
          <dd>
            {w("label.jointsMapped", {
              mapped: Object.keys(naming.mapped).length,
              n: receipt.joints,
              rig: naming.rig,
              own: naming.unmapped.length,
            })}
            {naming.joints.length + naming.unmapped.length > 0 && (
              <details>
                <summary>{w("label.show")}</summary>
                <ul>
                  {naming.joints.map((one) => (
                    <li key={one.source}>
                      <code>{one.source}</code> {one.name}{" "}
                      <span class={one.confidence < DOUBTFUL ? "guess" : "dim"}>{number(one.confidence, 2)}</span>
                    </li>
                  ))}
                  {naming.unmapped.map((one) => (
                    <li key={one.source}>
                      <code>{one.source}</code> <span class="dim">{one.why}</span>
                    </li>
                  ))}
                </ul>
              </details>
            )}
          </dd>
          <dd />
        </>
      )}
      <dt>{w("label.receiptNumbers")}</dt>
      <dd>
        {w("label.receiptNumbersText", { channels: receipt.channels, frames: receipt.frames })}
        {receipt.twins.length > 0 && <p class="dim">{w("help.twin")}</p>}
      </dd>
      <dd />
      {receipt.notices.length > 0 && (
        <>
          <dt>{w("label.notices")}</dt>
          <dd>
            <ul>
              {receipt.notices.slice(0, 20).map((one, index) => (
                <li key={index}>
                  {one.what} <span class="dim">{one.at}</span>
                </li>
              ))}
            </ul>
          </dd>
          <dd />
        </>
      )}
    </dl>
  );
}

/** What is known of the body, which is worked out when it is looked at. */
function CalibrationRow({ id, said }: { id: string; said: object }) {
  const found = useAsync((signal) => get("/documents/{id}/calibration", { path: { id }, signal }), [id], [said]);
  const known = found.value;
  if (found.error) return null;
  // The row is there from the first, so that the buttons above it do not move once the answer comes.
  return (
    <>
      <dt>{w("label.receiptBody")}</dt>
      <dd class="calibrated">
        {(Object.keys(FACTS) as Fact[]).map((name) => (
          <span key={name} title={known?.[name].reason}>
            {w(FACTS[name])}{" "}
            {known ? (
              <>
                <span class={/guessed|unknown/.test(known[name].origin) ? "guess" : ""}>{shownValue(known[name])}</span>{" "}
                <span class="dim">{w(ORIGINS[known[name].origin])}</span>
              </>
            ) : (
              <span class="dim">…</span>
            )}
          </span>
        ))}
      </dd>
      <dd />
    </>
  );
}

function LookedAt() {
  const { files, result } = looked.value!;
  return (
    <Dialog title={w("button.lookedAt")} onClose={() => (looked.value = null)} wide>
      {(result.clips as { files: string[]; receipt: Receipt; motion?: Told | null }[]).map((clip, index) => (
        <section key={index}>
          <h3>{clip.files.join(" + ")}</h3>
          {clip.motion && <LookedMotion told={clip.motion} />}
          <ReceiptView receipt={clip.receipt} documents={[]} />
        </section>
      ))}
      {result.problems.map(({ file, problem }, at) => (
        <Refusal key={at} file={file} problem={problem} />
      ))}
      <p class="row">
        {files.length > 0 && (
          <button
            type="button"
            class="button primary"
            onClick={() => {
              looked.value = null;
              addFiles(files);
            }}
          >
            {w("button.keep")}
          </button>
        )}
        <span class="dim">{w("label.notStored")}</span>
      </p>
    </Dialog>
  );
}
