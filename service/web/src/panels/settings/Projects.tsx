/** Who belongs to which project, and the links that were given away. */
import { useEffect, useState } from "preact/hooks";
import { ask, get, type Schemas } from "../../api/client";
import { note, refuse } from "../../state/notes";
import { Trouble } from "../../ui/Trouble";
import { useAsync } from "../../ui/useAsync";
import { w, when } from "../../words";
import { day, ROLE_WORDS, Secret, Table } from "./tables";

const ROLES = ["reader", "editor", "owner"] as const;
type Role = (typeof ROLES)[number];

export function Projects({ decides }: { decides: boolean }) {
  const projects = useAsync((signal) => get("/projects", { signal }), []);
  const [project, setProject] = useState("");
  const names = projects.value?.items ?? [];
  useEffect(() => { if (!names.includes(project)) setProject(names[0] ?? ""); }, [projects.value]);
  if (!names.length) return <Trouble error={projects.error} retry={projects.again} />;
  return (
    <section>
      <h3>{w("projectMembers")}</h3>
      <p class="row wrap"><select class="field" aria-label={w("project")} value={project} onChange={(event) => setProject(event.currentTarget.value)}>{names.map((one) => <option key={one}>{one}</option>)}</select></p>
      {project && <Members key={project} project={project} decides={decides} />}
    </section>
  );
}

function Members({ project, decides }: { project: string; decides: boolean }) {
  const members = useAsync((signal) => get("/members", { query: { project }, signal }), [project]);
  const [name, setName] = useState("");
  const [link, setLink] = useState("");
  const put = async (who: string, role: Role) => {
    try {
      await ask("put", "/members/{name}", { path: { name: who }, query: { project }, body: { role } });
      note(w("accountChanged", { name: who }));
      setName("");
    } catch (error) {
      refuse(error);
    }
    members.again();
  };
  const invite = async () => {
    try {
      setLink(location.origin + (await ask("post", "/invitations", { body: { role: "editor", project, hours: 72 } })).path);
    } catch (error) {
      refuse(error);
    }
  };
  const remove = (who: string) => void ask("delete", "/members/{name}", { path: { name: who }, query: { project } }).then(members.again, refuse);
  const role = (one: Schemas["MemberView"]) => decides && !one.everywhere
    ? <select class="field" aria-label={w("roleOf", { name: one.name })} value={one.role} onChange={(event) => void put(one.name, event.currentTarget.value as Role)}>{ROLES.map((each) => <option key={each} value={each}>{w(ROLE_WORDS[each])}</option>)}</select>
    : w(ROLE_WORDS[one.role]);
  const items = members.value?.items ?? [];
  return (
    <>
      <Trouble error={members.error} retry={members.again} />
      {members.value && !items.length && <p class="dim">{w("noMembers")}</p>}
      <Table head={[w("name"), w("role"), ""]} rows={items.map((one) => [
        one.name, role(one), one.everywhere ? <span key="e" class="dim">{w("inAllProjects")}</span> : decides && <button key="b" type="button" class="button dense" onClick={() => remove(one.name)}>{w("removeMember")}</button>,
      ])} />
      {decides && (
        <form class="row wrap" onSubmit={(event) => { event.preventDefault(); if (name.trim()) void put(name.trim(), "editor"); }}>
          <input class="field" aria-label={w("accountName")} placeholder={w("accountName")} value={name} onInput={(event) => setName(event.currentTarget.value)} />
          <button class="button" disabled={!name.trim()}>{w("addMember")}</button><button type="button" class="button" onClick={() => void invite()}>{w("inviteHere")}</button><span class="dim">{w("addMemberHelp")}</span>
        </form>
      )}
      {link && <Secret text={link} label={w("invitationMade")} />}
    </>
  );
}

export function Links() {
  const links = useAsync((signal) => get("/shares", { signal }), []);
  const items = links.value?.items ?? [];
  if (!items.length) return <Trouble error={links.error} retry={links.again} />;
  const end = (number: number) => void ask("delete", "/shares/{number}", { path: { number } }).then(links.again, refuse);
  return (
    <section>
      <h3>{w("links")}</h3>
      <p class="dim">{w("linksHelp")}</p>
      <Table head={[w("name"), w("project"), w("since"), w("expires"), ""]} rows={items.map((one) => [
        <span key="n">{one.name} <span class="dim">{w("sharedCount", { n: one.documents.length })} · {one.author}</span></span>, one.project, when(one.created), day(one.expires),
        <button key="b" type="button" class="button dense" onClick={() => end(one.number)}>{w("revoke")}</button>,
      ])} />
    </section>
  );
}
