/** Who belongs to a project, and the links into it that were given away. */
import { entryOf } from "../../lists";
import { useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { note, refuse } from "../../state/session/notes";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { askOwned } from "../../state/session/rights";
import { day, ROLE_WORDS, Secret, Table } from "./tables";
import { s } from "./words";

const ROLES = ["reader", "editor", "owner"] as const;
type Role = (typeof ROLES)[number];

export function Members({ project, decides }: { project: string; decides: boolean }) {
  const owned = useAsync(askOwned, []).value?.owned ?? true;
  const members = useAsync((signal) => get("/members", { query: { project }, signal }), [project]);
  const [name, setName] = useState("");
  const [link, setLink] = useState("");
  const put = async (who: string, role: Role) => {
    try {
      await ask("put", "/members/{name}", { path: { name: who }, query: { project }, body: { role } });
      note(w("label.accountChanged", { name: who }));
      setName("");
    } catch (error) {
      refuse(error);
    }
    members.again();
  };
  const invite = async () => {
    try {
      setLink(
        location.origin + (await ask("post", "/invitations", { body: { role: "editor", project, hours: 72 } })).path,
      );
    } catch (error) {
      refuse(error);
    }
  };
  const remove = (who: string) =>
    void ask("delete", "/members/{name}", { path: { name: who }, query: { project } }).then(members.again, refuse);
  const role = (one: Schemas["MemberView"]) =>
    decides && !one.everywhere ? (
      <select
        class="field"
        aria-label={w("label.roleOf", { name: one.name })}
        value={one.role}
        onChange={(event) => void put(one.name, event.currentTarget.value as Role)}
      >
        {ROLES.map((each) => (
          <option key={each} value={each}>
            {w(entryOf(ROLE_WORDS, each))}
          </option>
        ))}
      </select>
    ) : (
      w(entryOf(ROLE_WORDS, one.role))
    );
  const items = members.value?.items ?? [];
  return (
    <section>
      <h3>{w("label.projectMembers")}</h3>
      <Trouble error={members.error} retry={members.again} />
      {members.value && !items.length && <p class="dim">{w("help.noMembers")}</p>}
      <Table
        head={[w("label.name"), w("label.role"), ""]}
        rows={items.map((one) => [
          one.name,
          role(one),
          one.everywhere ? (
            <span key="e" class="dim">
              {w("label.inAllProjects")}
            </span>
          ) : (
            decides && (
              <button key="b" type="button" class="button dense" onClick={() => remove(one.name)}>
                {w("button.removeMember")}
              </button>
            )
          ),
        ])}
      />
      {decides && !owned && (
        <p class="row wrap">
          <span class="dim">{s("help.ownerFirstWhere")}</span>
          <a class="button" href="/settings">
            {s("button.createAccount")}
          </a>
        </p>
      )}
      {decides && owned && (
        <form
          class="row wrap"
          aria-label={w("label.projectMembers")}
          onSubmit={(event) => {
            event.preventDefault();
            if (name.trim()) void put(name.trim(), "editor");
          }}
        >
          <input
            class="field"
            aria-label={w("label.accountName")}
            placeholder={w("label.accountName")}
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <button class="button" disabled={!name.trim()}>
            {w("button.addMember")}
          </button>
          <button type="button" class="button" onClick={() => void invite()}>
            {w("button.inviteHere")}
          </button>
          <span class="dim">{w("help.addMemberHelp")}</span>
        </form>
      )}
      {link && <Secret text={link} label={w("help.invitationMade")} />}
    </section>
  );
}

export function Links({ project }: { project: string }) {
  const links = useAsync((signal) => get("/shares", { query: { project }, signal }), [project]);
  const items = links.value?.items ?? [];
  if (!items.length) return <Trouble error={links.error} retry={links.again} />;
  const end = (number: number) =>
    void ask("delete", "/shares/{number}", { path: { number } }).then(links.again, refuse);
  return (
    <section>
      <h3>{w("label.links")}</h3>
      <p class="dim">{w("help.linksHelp")}</p>
      <Table
        head={[w("label.name"), w("label.since"), w("label.expires"), ""]}
        rows={items.map((one) => [
          <span key="n">
            {one.name}{" "}
            <span class="dim">
              {w("label.sharedCount", { n: one.documents.length })} · {one.author}
            </span>
          </span>,
          when(one.created),
          day(one.expires),
          <button key="b" type="button" class="button dense" onClick={() => end(one.number)}>
            {w("button.revoke")}
          </button>,
        ])}
      />
    </section>
  );
}
