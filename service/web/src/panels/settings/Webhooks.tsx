/** Addresses that the server tells of what was done, and the log of what it sent there. */
import { useEffect, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { note, refuse } from "../../state/session/notes";
import { Dialog } from "../../ui/Dialog";
import { Icon, type IconName } from "../../ui/icons";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { KINDS } from "./Activity";
import { ownsIn } from "../../state/session/rights";
import { day, Secret } from "./tables";
import { s } from "./words";

type Webhook = Schemas["WebhookView"];
type Delivery = Schemas["DeliveryView"];
const LOOK_AGAIN = 3000; // ms; the feed of events does not tell of messages
const PAGE = 20;

export function Webhooks() {
  const me = useAsync((signal) => get("/account", { signal }), []);
  const hooks = useAsync(
    async (signal) => (me.value?.rights.includes("own") ? (await get("/webhooks", { signal })).items : null),
    [me.value],
  );
  const [made, setMade] = useState<Schemas["WebhookMade"] | null>(null);
  const [ending, setEnding] = useState<Webhook | null>(null);
  if (me.value && !me.value.rights.includes("own")) return <p class="dim">{s("help.ownersHooks")}</p>;
  const end = async (one: Webhook) => {
    try {
      await ask("delete", "/webhooks/{number}", { path: { number: one.number } });
      if (made?.number === one.number) setMade(null);
      hooks.set((hooks.value ?? []).filter((other) => other.number !== one.number));
      setEnding(null);
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <>
      <p class="dim hooks-help">{s("help.hooksHelp")}</p>
      <Trouble error={me.error ?? hooks.error} retry={me.error ? me.again : hooks.again} />
      {made && <Secret text={made.secret} label={s("help.hookMade")} />}
      {hooks.value?.length === 0 && <p class="dim">{s("help.noHooks")}</p>}
      <ul class="hooks">
        {hooks.value?.map((one) => (
          <Hook key={one.number} hook={one} ending={ending === one} onEnd={() => setEnding(one)} />
        ))}
      </ul>
      {me.value && (
        <AddHook
          me={me.value}
          onMade={(one) => {
            setMade(one);
            hooks.again();
          }}
        />
      )}
      {ending && (
        <Dialog title={s("help.endHook")} onClose={() => setEnding(null)}>
          <p class="hook-url">{ending.url}</p>
          <p>{s("help.endHookMeans")}</p>
          <p class="row dialog-end">
            <span class="grow" />
            <button type="button" class="button" onClick={() => setEnding(null)}>
              {w("button.cancel")}
            </button>
            <button type="button" class="button danger" autoFocus onClick={() => void end(ending)}>
              {w("button.delete")}
            </button>
          </p>
        </Dialog>
      )}
    </>
  );
}

function Hook({ hook, ending, onEnd }: { hook: Webhook; ending: boolean; onEnd: () => void }) {
  const [open, setOpen] = useState(false);
  const about = [
    hook.project ?? w("label.allProjects"),
    hook.kinds.length ? hook.kinds.map((one) => s(`label.kind_${one}`)).join(", ") : s("label.anyKind"),
    hook.author,
    when(hook.created),
  ];
  return (
    <li>
      <div class="row wrap">
        <div class="grow">
          <div class="hook-url">{hook.url}</div>
          <div class="dim">{about.join(" · ")}</div>
          {hook.ended && (
            <div class="hook-ended">
              <Icon name="warn" />
              {s("help.hookEnded", { day: day(hook.ended) })}
            </div>
          )}
        </div>
        <button type="button" class="button dense" aria-expanded={open} onClick={() => setOpen(!open)}>
          {s("label.sentLog")}
        </button>
        <button type="button" class="button dense" onClick={onEnd}>
          {w("button.delete")}
        </button>
      </div>
      {/* One that is about to go is not asked for its log any more. */}
      {open && !ending && <Log number={hook.number} />}
    </li>
  );
}

const STATES: Record<Delivery["state"], IconName> = { waiting: "loop", sent: "check", failed: "warn" };

function Log({ number }: { number: number }) {
  const [pages, setPages] = useState(1);
  const found = useAsync(
    (signal) => get("/webhooks/{number}/messages", { path: { number }, query: { limit: PAGE * pages }, signal }),
    [number],
    [pages],
  );
  const items = found.value?.items ?? [];
  useEffect(() => {
    const timer = window.setInterval(() => void (document.hidden || found.again()), LOOK_AGAIN);
    return () => window.clearInterval(timer);
  }, []);
  const again = async (one: Delivery) => {
    try {
      await ask("post", "/webhooks/{number}/messages/{message}", { path: { number, message: one.number } });
      note(s("label.sentAgain"));
      found.again();
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <div class="hook-log">
      <Trouble error={found.error} retry={found.again} />
      {found.value && !items.length && <p class="dim">{s("help.nothingSent")}</p>}
      {items.length > 0 && (
        <ol>
          {items.map((one) => (
            <li key={one.number}>
              <code title={one.message}>{one.type}</code>
              <time class="dim" dateTime={one.created}>
                {when(one.created)}
              </time>
              <span class={`hook-state ${one.state}`}>
                <Icon name={STATES[one.state]} />
                {s(`label.state_${one.state}`)}
              </span>
              <span class="dim grow">
                {[
                  one.attempts > 0 && s("label.attempts", { n: one.attempts }),
                  one.problem ?? (one.status ? String(one.status) : ""),
                ]
                  .filter(Boolean)
                  .join(" · ")}
              </span>
              <button type="button" class="button dense" onClick={() => void again(one)}>
                {s("button.sendAgain")}
              </button>
            </li>
          ))}
        </ol>
      )}
      {found.value?.next_cursor && PAGE * pages < 1000 && (
        <p>
          <button type="button" class="button dense" onClick={() => setPages(pages + 1)}>
            {w("label.more")}
          </button>
        </p>
      )}
    </div>
  );
}

function AddHook({ me, onMade }: { me: Schemas["Me"]; onMade: (made: Schemas["WebhookMade"]) => void }) {
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const own = (projects.value?.items ?? []).filter((one) => ownsIn(me, one));
  const all = me.rights.includes("operate");
  const [url, setUrl] = useState("");
  const [project, setProject] = useState("");
  const [kinds, setKinds] = useState<Webhook["kinds"]>([]);
  const [trouble, setTrouble] = useState<unknown>(null);
  const chosen = all ? project : project || (own[0] ?? "");
  const add = async (event: Event) => {
    event.preventDefault();
    setTrouble(null);
    try {
      const made = await ask("post", "/webhooks", { body: { url: url.trim(), project: chosen || null, kinds } });
      setUrl("");
      setKinds([]);
      onMade(made);
    } catch (error) {
      setTrouble(error);
    }
  };
  return (
    <section>
      <h3>{s("button.addHook")}</h3>
      <form class="hook-form" onSubmit={(event) => void add(event)}>
        <div class="row wrap">
          <input
            class="field grow"
            type="url"
            required
            minLength={8}
            maxLength={2000}
            aria-label={s("label.hookAddress")}
            placeholder="https://"
            value={url}
            onInput={(event) => setUrl(event.currentTarget.value)}
          />
          <select
            class="field"
            aria-label={w("label.project")}
            value={chosen}
            onChange={(event) => setProject(event.currentTarget.value)}
          >
            {all && <option value="">{w("label.allProjects")}</option>}
            {own.map((one) => (
              <option key={one}>{one}</option>
            ))}
          </select>
          <button type="submit" class="button" disabled={!url.trim()}>
            {s("button.addHook")}
          </button>
        </div>
        <fieldset>
          <legend class="dim">{s("label.hookKinds")}</legend>
          <div class="row wrap">
            {KINDS.filter((one) => one !== "token" || all).map((one) => (
              <label key={one} class="row">
                <input
                  type="checkbox"
                  checked={kinds.includes(one)}
                  onChange={(event) =>
                    setKinds(event.currentTarget.checked ? [...kinds, one] : kinds.filter((each) => each !== one))
                  }
                />{" "}
                {s(`label.kind_${one}`)}
              </label>
            ))}
          </div>
        </fieldset>
        <Trouble error={trouble} />
      </form>
    </section>
  );
}
