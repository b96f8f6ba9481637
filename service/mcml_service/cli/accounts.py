"""`mcml account`: people of a repository."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

import typer

from mcml_schemas.team.shares import ShareRequest
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ServerOption,
    choose_settings,
    console,
    open_client,
    open_database,
)
from mcml_service.cli.terminal.requests import request_of

Role: TypeAlias = Literal["member", "reader", "editor", "owner"]
ProjectRole: TypeAlias = Literal["reader", "editor", "owner"]
RoleOption: TypeAlias = Annotated[
    Role, typer.Option(help="Role in all projects; a member has a role in some, see `mcml project`")
]
Name: TypeAlias = Annotated[str, typer.Argument(help="Name of the account")]


def invite(
    role: RoleOption = "editor",
    project: Annotated[str | None, typer.Option(help="Give the role in this project alone")] = None,
    hours: Annotated[int, typer.Option(min=1, help="How long the invitation can be accepted")] = 72,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Make a link with which a person can create an account. It is shown only once."""
    made = open_client(database, server).call("invite", request={"role": role, "project": project, "hours": hours})
    home = (server or f"http://127.0.0.1:{choose_settings(database).port}").rstrip("/")
    print(f"{home}{made.path}")
    where = "" if project is None else f" of the project {project}"
    console.print(f"for one {role}{where}, within {made.hours} hours", style="dim")


def add(name: Name, role: RoleOption = "editor", database: DatabaseOption = None) -> None:
    """Create an account on this machine; prompts for its password."""
    from mcml_service.passwords import check_name, hash_password

    name = check_name(name)
    made = hash_password(_ask_password(), name)
    with open_database(choose_settings(database)).write() as tx:
        tx.accounts.add(name, role, made)
    console.print(f"{name} is {'an' if role[0] in 'eo' else 'a'} {role}")


def password(name: Name, database: DatabaseOption = None) -> None:
    """Reset the password of an account of a local store, if it was forgotten; its sessions end."""
    from mcml_service.passwords import hash_password

    store = open_database(choose_settings(database))
    with store.read() as tx:
        person = tx.accounts.get(name)
    made = hash_password(_ask_password(), person.name)
    with store.write() as tx:
        tx.sessions.end_all(tx.accounts.change(name, password=made).key)
    console.print(f"{name} has another password")


def role(
    name: Name,
    role: Annotated[Role, typer.Argument(help="New role in all projects")],
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Change the role of an account."""
    open_client(database, server).call("change_account", name=name, change={"role": role})
    console.print(f"{name}: {role}")


def add_member(
    project: Annotated[str, typer.Argument(help="Name of the project")],
    name: Name,
    role: Annotated[ProjectRole, typer.Option(help="Role in the project")] = "editor",
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Add a member to a project, or change their role."""
    open_client(database, server).call("set_member", name=name, change={"role": role}, project=project)
    console.print(f"{name} is {'an' if role[0] in 'eo' else 'a'} {role} of {project}")


def share(
    documents: Annotated[list[str], typer.Argument(help="Ids of documents of one project")],
    name: Annotated[str, typer.Option(help="Whom it is for")] = "guest",
    days: Annotated[int, typer.Option(min=1, max=365, help="How long it opens them")] = 14,
    format: Annotated[list[str] | None, typer.Option(help="Allowed export format; may be repeated")] = None,
    fixed: Annotated[bool, typer.Option("--fixed", help="As they are now, without later edits")] = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Make a share link, which shows some documents to people without an account. It is shown only once."""
    asked = {"name": name, "documents": documents, "days": days, "formats": format or [], "latest": not fixed}
    made = open_client(database, server).call("add_share", request=request_of(ShareRequest, asked))
    home = (server or f"http://127.0.0.1:{choose_settings(database).port}").rstrip("/")
    print(f"{home}{made.path}")
    console.print(f"link {made.number}, until {made.expires[:10]}", style="dim")


def close(name: Name, database: DatabaseOption = None, server: ServerOption = None) -> None:
    """Close an account: it and its tokens lose access."""
    open_client(database, server).call("change_account", name=name, change={"closed": True})
    console.print(f"{name} is closed")


def reopen(name: Name, database: DatabaseOption = None, server: ServerOption = None) -> None:
    """Reopen a closed account."""
    open_client(database, server).call("change_account", name=name, change={"closed": False})
    console.print(f"{name} is open")


def _ask_password() -> str:
    """Read a password: typed twice, or from a pipe."""
    answer: str = typer.prompt("Password", hide_input=True, confirmation_prompt=True)
    return answer
