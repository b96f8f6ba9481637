/** A project: how much is in it and may be, its archive, its file, its people. */
import { useState } from "preact/hooks";
import { address, ask, get, type Schemas } from "../../api/client";
import { note, refuse } from "../../state/session/notes";
import { param, setParams } from "../../state/session/route";
import { AskName } from "../../ui/forms/AskName";
import { Dialog } from "../../ui/Dialog";
import { Icon } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { number, w } from "../../words";
import { ImportProject } from "./ImportProject";
import { Links, Members } from "./Members";
import { editsIn, ownsIn } from "../../state/session/rights";
import { size, unitName, unitOf, UNITS, type Unit } from "./sizes";
import { day } from "./tables";
import { Vocabulary } from "./Vocabulary";
import { s } from "./words";

type Project = Schemas["ProjectView"];

export function ProjectPage() {
  const me = useAsync((signal) => get("/account", { signal }), []);
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const [naming, setNaming] = useState(false);
  const names = projects.value?.items ?? [];
  const project = names.includes(param("project")) ? param("project") : (names[0] ?? "");
  const may = (right: string) => me.value?.rights.includes(right) ?? false;
  return (
    <>
      <p class="row wrap">
        {names.length > 0 && (
          <select
            class="field"
            aria-label={w("label.project")}
            value={project}
            onChange={(event) => setParams({ project: event.currentTarget.value }, true)}
          >
            {names.map((one) => (
              <option key={one}>{one}</option>
            ))}
          </select>
        )}
        {may("edit") && (
          <button type="button" class="button" onClick={() => setNaming(true)}>
            <Icon name="plus" />
            {s("button.newProject")}
          </button>
        )}
      </p>
      <Trouble error={me.error ?? projects.error} retry={projects.again} />
      {me.value && project && <Chosen key={project} me={me.value} project={project} />}
      {may("operate") && (
        <ImportProject
          onDone={(name) => {
            projects.again();
            setParams({ project: name }, true);
          }}
        />
      )}
      {naming && (
        <AskName
          title={s("button.newProject")}
          onName={async (name) => {
            const made = await ask("put", "/project", { query: { project: name } });
            projects.again();
            setParams({ project: made.name }, true);
            note(s("label.projectCreated", { name: made.name }));
          }}
          onClose={() => setNaming(false)}
        >
          <p class="dim">{s("help.newProjectHelp")}</p>
        </AskName>
      )}
    </>
  );
}

function Chosen({ me, project }: { me: Schemas["Me"]; project: string }) {
  const found = useAsync((signal) => get("/project", { query: { project }, signal }), [project]);
  const [asked, setAsked] = useState<"" | "archive" | "bounds">("");
  const decides = ownsIn(me, project);
  const one = found.value;
  const change = async (body: Schemas["ProjectChange"], said: string) => {
    await ask("patch", "/project", { query: { project }, body });
    note(said);
    found.again();
  };
  return (
    <>
      <Trouble error={found.error} retry={found.again} />
      {one?.archived && (
        <div class="banner warn settings-banner">
          <Icon name="warn" />
          <div class="grow">
            <strong>{s("label.archivedSince", { day: day(one.archived) })}</strong>
            <p>{s("help.archivedHelp")}</p>
          </div>
        </div>
      )}
      {one && <Amounts project={one} />}
      <p class="row wrap project-acts">
        <a class="button" href={`/library?project=${encodeURIComponent(project)}`}>
          <Icon name="library" />
          {s("button.openClips")}
        </a>
        <a class="button" href={`/settings/activity?project=${encodeURIComponent(project)}`}>
          <Icon name="list" />
          {w("label.activity")}
        </a>
        {decides ? (
          <a class="button" href={address("/projects/export", {}, { project })} download>
            <Icon name="export" />
            {s("button.exportFile")}
          </a>
        ) : (
          <>
            <button type="button" class="button" disabled aria-describedby="why-no-export">
              <Icon name="export" />
              {s("button.exportFile")}
            </button>
            <span id="why-no-export" class="dim">
              {s("help.ownersExport")}
            </span>
          </>
        )}
        {one && me.rights.includes("operate") && (
          <button type="button" class="button" onClick={() => setAsked("bounds")}>
            {s("button.changeBounds")}
          </button>
        )}
        {one && decides && (
          <button type="button" class="button" onClick={() => setAsked("archive")}>
            {s(one.archived ? "button.openAgain" : "button.archive")}
          </button>
        )}
      </p>
      {decides && <p class="dim">{s("help.exportHelp")}</p>}
      <ReviewRequired project={one} decides={decides} change={change} />
      <Vocabulary project={project} edits={one !== undefined && !one.archived && editsIn(me, project)} />
      <Members project={project} decides={decides} />
      {me.rights.includes("edit") && <Links project={project} />}
      {one && asked === "bounds" && (
        <Bounds project={one} onSave={(body) => change(body, s("label.boundsChanged"))} onClose={() => setAsked("")} />
      )}
      {one && asked === "archive" && (
        <Archive
          project={one}
          onDo={(archived) => change({ archived }, s(archived ? "label.archived" : "label.opened", { name: project }))}
          onClose={() => setAsked("")}
        />
      )}
    </>
  );
}

function ReviewRequired({
  project,
  decides,
  change,
}: {
  project: Project | undefined;
  decides: boolean;
  change: (body: Schemas["ProjectChange"], said: string) => Promise<void>;
}) {
  if (!project) return null;
  const required = !project.review_required;
  const turn = () => change({ review_required: required }, s(required ? "label.reviewOn" : "label.reviewOff"));
  return (
    <p class="review-required">
      <label class="row">
        <input
          type="checkbox"
          checked={project.review_required}
          disabled={!decides || Boolean(project.archived)}
          onChange={() => void turn().catch(refuse)}
        />
        {s("label.reviewRequired")}
      </label>
      <span class="dim">{s("help.reviewRequired")}</span>
    </p>
  );
}

function Amounts({ project }: { project: Project }) {
  const row = (label: string, held: number, most: number | null | undefined, text: (value: number) => string) => (
    <>
      <dt>{label}</dt>
      <dd>
        {typeof most === "number" && (
          <meter
            min={0}
            max={Math.max(1, most)}
            value={Math.min(held, most)}
            class={held >= most ? "full" : ""}
            aria-label={label}
          />
        )}
        <span>
          {typeof most === "number" ? (
            s("label.heldOf", { held: text(held), most: text(most) })
          ) : (
            <>
              {text(held)} <span class="dim">· {s("label.noBound")}</span>
            </>
          )}
          {typeof most === "number" && held > most && (
            <span class="amount-over">
              <Icon name="warn" />
              {s("label.overBound")}
            </span>
          )}
        </span>
      </dd>
    </>
  );
  return (
    <dl class="amounts">
      {row(s("label.documents"), project.documents, project.most_documents, (value) => number(value))}
      {row(s("label.files"), project.bytes, project.most_bytes, size)}
    </dl>
  );
}

function Bounds({
  project,
  onSave,
  onClose,
}: {
  project: Project;
  onSave: (body: Schemas["ProjectChange"]) => Promise<void>;
  onClose: () => void;
}) {
  const first = project.most_bytes ? unitOf(project.most_bytes) : "gigabyte";
  const [documents, setDocuments] = useState(project.most_documents ? String(project.most_documents) : "");
  const [bytes, setBytes] = useState(project.most_bytes ? String(project.most_bytes / UNITS[first]) : "");
  const [unit, setUnit] = useState<Unit>(first);
  const save = async (event: Event) => {
    event.preventDefault();
    try {
      await onSave({
        most_documents: Number(documents) || 0,
        most_bytes: Math.round((Number(bytes) || 0) * UNITS[unit]),
      });
      onClose();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <Dialog title={s("label.boundsOf", { name: project.name })} onClose={onClose}>
      <form class="bounds" onSubmit={(event) => void save(event)}>
        <p class="dim">{s("help.boundsHelp")}</p>
        <label for="most-documents">{s("label.mostDocuments")}</label>
        <input
          id="most-documents"
          class="field"
          type="number"
          min={1}
          step={1}
          autoFocus
          placeholder={s("label.noBound")}
          value={documents}
          onInput={(event) => setDocuments(event.currentTarget.value)}
        />
        <label for="most-bytes">{s("label.mostBytes")}</label>
        <span class="row">
          <input
            id="most-bytes"
            class="field grow"
            type="number"
            min={0}
            step="any"
            placeholder={s("label.noBound")}
            value={bytes}
            onInput={(event) => setBytes(event.currentTarget.value)}
          />
          <select
            class="field"
            aria-label={w("label.unit")}
            value={unit}
            onChange={(event) => setUnit(event.currentTarget.value as Unit)}
          >
            {(Object.keys(UNITS) as Unit[]).map((one) => (
              <option key={one} value={one}>
                {unitName(one)}
              </option>
            ))}
          </select>
        </span>
        <p class="row">
          <span class="grow" />
          <button type="button" class="button" onClick={onClose}>
            {w("button.cancel")}
          </button>
          <button type="submit" class="button primary">
            {w("button.save")}
          </button>
        </p>
      </form>
    </Dialog>
  );
}

function Archive({
  project,
  onDo,
  onClose,
}: {
  project: Project;
  onDo: (archived: boolean) => Promise<void>;
  onClose: () => void;
}) {
  const archive = !project.archived;
  const act = () => void onDo(archive).then(onClose, refuse);
  return (
    <Dialog title={s(archive ? "help.archiveIt" : "help.openIt", { name: project.name })} onClose={onClose}>
      <p>{s(archive ? "help.archiveMeans" : "help.openMeans")}</p>
      <p class="row dialog-end">
        <span class="grow" />
        <button type="button" class="button" onClick={onClose}>
          {w("button.cancel")}
        </button>
        <button type="button" class="button primary" autoFocus onClick={act}>
          {s(archive ? "button.archive" : "button.openAgain")}
        </button>
      </p>
    </Dialog>
  );
}
