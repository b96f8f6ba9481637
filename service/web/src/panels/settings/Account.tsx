/** Who one is here, one's tokens; and for owners, the people of the repository. */
import { entryOf } from "../../lists";
import { useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { note, refuse } from "../../state/session/notes";
import { AskName } from "../../ui/forms/AskName";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when, type Word } from "../../words";
import { FirstOwner } from "./FirstOwner";
import { askOwned } from "../../state/session/rights";
import { day, ROLE_WORDS, Secret, Table } from "./tables";

const ROLES = ["member", "reader", "editor", "owner"] as const;
const SCOPES = ["read", "edit", "operate"] as const;
const SCOPE_WORDS: Record<string, Word> = {
  read: "label.scopeRead",
  edit: "label.scopeEdit",
  operate: "label.scopeOperate",
};

export function Account() {
  const me = useAsync(askOwned, []);
  if (!me.value) return <Trouble error={me.error} retry={me.again} />;
  const { name, role, rights, projects, owned } = me.value;
  const leave = () => void ask("delete", "/session").then(() => location.assign("/login"), refuse);
  return (
    <>
      <h2>{w("label.account")}</h2>
      <p class="row wrap">
        <span>
          {role ? w("help.signedIn", { name, role: w(entryOf(ROLE_WORDS, role)) }) : w("help.noAccount", { name })}
        </span>
        {role && (
          <button type="button" class="button" onClick={leave}>
            {w("button.signOut")}
          </button>
        )}
      </p>
      {role && <Password />}
      {projects.length > 0 && (
        <p class="dim">{projects.map((one) => `${one.project}: ${w(entryOf(ROLE_WORDS, one.role))}`).join(" · ")}</p>
      )}
      {!owned && <FirstOwner />}
      <Tokens owned={owned} scopes={SCOPES.filter((scope) => rights.includes(scope))} />
      {owned && rights.includes("operate") && <People me={name} />}
    </>
  );
}

function Password() {
  const [given, setGiven] = useState({ current: "", next: "" });
  const change = async (event: Event) => {
    event.preventDefault();
    try {
      await ask("put", "/account/password", { body: { current: given.current, new: given.next } });
      location.assign("/login");
    } catch (error) {
      refuse(error);
    }
  };
  return (
    <details class="account-part">
      <summary>{w("label.changePassword")}</summary>
      <form class="row wrap" onSubmit={(event) => void change(event)}>
        <label>
          {w("label.currentPassword")}{" "}
          <input
            class="field"
            type="password"
            autocomplete="current-password"
            required
            value={given.current}
            onInput={(event) => setGiven({ ...given, current: event.currentTarget.value })}
          />
        </label>
        <label>
          {w("label.newPassword")}{" "}
          <input
            class="field"
            type="password"
            autocomplete="new-password"
            minLength={10}
            maxLength={256}
            required
            value={given.next}
            onInput={(event) => setGiven({ ...given, next: event.currentTarget.value })}
          />
        </label>
        <button class="button primary">{w("button.change")}</button>
        <span class="dim">{w("help.passwordHelp")}</span>
      </form>
    </details>
  );
}

function Tokens({ scopes, owned }: { scopes: (typeof SCOPES)[number][]; owned: boolean }) {
  const tokens = useAsync((signal) => get("/tokens", { signal }), []);
  const all = useAsync((signal) => get("/projects", { signal }), []);
  const [asked, setAsked] = useState(false);
  const [project, setProject] = useState("");
  const [scope, setScope] = useState<(typeof SCOPES)[number]>("read");
  const [made, setMade] = useState<Schemas["TokenMade"] | null>(null);
  const add = async (name: string) => {
    setMade(await ask("post", "/tokens", { body: { name, scope, projects: project ? [project] : [], days: 90 } }));
    tokens.again();
  };
  // The first token would close the repository to who has none.
  if (!owned && !tokens.value?.items.length) return <Trouble error={tokens.error} retry={tokens.again} />;
  const end = (name: string) => void ask("delete", "/tokens/{name}", { path: { name } }).then(tokens.again, refuse);
  return (
    <section>
      <h3>{w("label.tokens")}</h3>
      <p class="dim">{w("help.tokensHelp")}</p>
      {made && <Secret text={made.token} label={w("help.tokenMade", { name: made.name })} />}
      <Table
        head={[w("label.name"), w("label.mayDo"), w("label.expires"), w("label.lastUsed"), ""]}
        rows={(tokens.value?.items ?? []).map((one) => [
          <span key="n">
            {one.name}{" "}
            <span class="dim">
              {one.hint}…{one.account && ` · ${one.account}`}
            </span>
          </span>,
          <span key="s">
            {w(entryOf(SCOPE_WORDS, one.scope))}
            {one.projects?.length ? <span class="dim"> · {one.projects.join(", ")}</span> : null}
          </span>,
          one.expires ? day(one.expires) : w("label.never"),
          one.used ? when(one.used) : w("label.never"),
          <button key="b" type="button" class="button dense" onClick={() => end(one.name)}>
            {w("button.revoke")}
          </button>,
        ])}
      />
      <p class="row wrap">
        <select
          class="field"
          aria-label={w("label.mayDo")}
          value={scope}
          onChange={(event) => setScope(event.currentTarget.value as typeof scope)}
        >
          {scopes.map((one) => (
            <option key={one} value={one}>
              {w(entryOf(SCOPE_WORDS, one))}
            </option>
          ))}
        </select>
        <select
          class="field"
          aria-label={w("label.project")}
          value={project}
          onChange={(event) => setProject(event.currentTarget.value)}
        >
          <option value="">{w("label.allProjects")}</option>
          {(all.value?.items ?? []).map((one) => (
            <option key={one}>{one}</option>
          ))}
        </select>
        <button type="button" class="button" onClick={() => setAsked(true)}>
          {w("button.makeToken")}
        </button>
      </p>
      {asked && <AskName title={w("button.makeToken")} onName={add} onClose={() => setAsked(false)} />}
    </section>
  );
}

function People({ me }: { me: string }) {
  const people = useAsync((signal) => get("/accounts", { signal }), []);
  const open = useAsync((signal) => get("/invitations", { signal }), []);
  const [role, setRole] = useState<(typeof ROLES)[number]>("editor");
  const [link, setLink] = useState("");
  const change = async (name: string, body: Schemas["AccountChange"]) => {
    try {
      await ask("patch", "/accounts/{name}", { path: { name }, body });
      note(w("label.accountChanged", { name }));
    } catch (error) {
      refuse(error);
    }
    people.again();
  };
  const invite = async () => {
    try {
      const made = await ask("post", "/invitations", { body: { role, hours: 72 } });
      setLink(location.origin + made.path);
      open.again();
    } catch (error) {
      refuse(error);
    }
  };
  const takeBack = (number: number) =>
    void ask("delete", "/invitations/{number}", { path: { number } }).then(open.again, refuse);
  const roles = (label: string, value: string, set: (next: (typeof ROLES)[number]) => void) => (
    <select
      class="field"
      aria-label={label}
      value={value}
      onChange={(event) => set(event.currentTarget.value as (typeof ROLES)[number])}
    >
      {ROLES.map((one) => (
        <option key={one} value={one}>
          {w(entryOf(ROLE_WORDS, one))}
        </option>
      ))}
    </select>
  );
  return (
    <section>
      <h3>{w("label.people")}</h3>
      <Trouble error={people.error} retry={people.again} />
      <Table
        head={[w("label.name"), w("label.role"), w("label.since"), ""]}
        rows={(people.value?.items ?? []).map((one) => [
          <span key="n" class={one.closed ? "dim" : ""}>
            {one.name}
            {one.closed && ` · ${w("label.accountClosed")}`}
          </span>,
          roles(w("label.roleOf", { name: one.name }), one.role, (next) => void change(one.name, { role: next })),
          when(one.created),
          one.name === me ? (
            ""
          ) : (
            <button
              key="b"
              type="button"
              class="button dense"
              onClick={() => void change(one.name, { closed: !one.closed })}
            >
              {w(one.closed ? "button.reopenAccount" : "button.closeAccount")}
            </button>
          ),
        ])}
      />
      <p class="row wrap">
        {roles(w("label.role"), role, setRole)}
        <button type="button" class="button" onClick={() => void invite()}>
          {w("button.invite")}
        </button>
        <span class="dim">{w("help.inviteHelp")}</span>
      </p>
      {link && <Secret text={link} label={w("help.invitationMade")} />}
      {(open.value?.items ?? []).length > 0 && (
        <Table
          head={[w("button.invitations"), w("label.role"), w("label.expires"), ""]}
          rows={(open.value?.items ?? []).map((one) => [
            w("label.invitedBy", { name: one.author }),
            one.project ? `${one.project}: ${w(entryOf(ROLE_WORDS, one.role))}` : w(entryOf(ROLE_WORDS, one.role)),
            day(one.expires),
            <button key="b" type="button" class="button dense" onClick={() => takeBack(one.number)}>
              {w("button.revoke")}
            </button>,
          ])}
        />
      )}
    </section>
  );
}
