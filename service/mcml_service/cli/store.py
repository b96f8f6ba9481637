"""`mcml db` and `mcml token`: the store itself."""

from __future__ import annotations

from dataclasses import asdict
from datetime import timedelta
from pathlib import Path
from typing import Annotated, Literal

import typer

from mcml.errors import McmlError
from mcml_service.actions.keeping.check_uploads import compare_all
from mcml_service.actions.keeping.keep_room import compact_store, forget_activity, prune_history
from mcml_service.actions.keeping.keep_store import backup, restore
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    JsonOption,
    choose_settings,
    console,
    find_database,
    open_database,
    print_json,
    table,
    upgrade_database,
)
from mcml_service.storage.core.identifiers import now


def upgrade(database: DatabaseOption = None) -> None:
    """Bring the store's schema to this program's version; an SQLite store is copied to a file beside it first."""
    settings = choose_settings(database)
    before, wanted = find_database(settings).schema_versions()
    upgrade_database(settings)
    if before is None:
        console.print(f"schema none -> {wanted}")
    elif before == wanted:
        console.print(f"schema {wanted}, nothing to do")


def backup_(output: Annotated[Path, typer.Argument(help="File to write")], database: DatabaseOption = None) -> None:
    """Copy the whole store into one file while it is in use."""
    size = backup(open_database(choose_settings(database)), output)
    console.print(f"wrote {output} ({size / 1e6:,.1f} MB)")


def restore_(
    source: Annotated[Path, typer.Argument(help="A file that `mcml db backup` wrote")],
    database: DatabaseOption = None,
) -> None:
    """Fill an empty store from a backup."""
    settings = choose_settings(database)
    documents = restore(open_database(settings), source)
    console.print(f"restored {documents:,} documents")


def check(
    database: DatabaseOption = None,
    deep: Annotated[
        bool, typer.Option("--deep", help="Read the kept files again and compare the numbers; past revisions too")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Compare every row with its checksum, read every uploaded file once, and report errors."""
    settings = choose_settings(database)
    store = open_database(settings)
    faults, unread = store.check(past=deep), []
    if deep:
        with store.read() as tx:
            for compared in compare_all(tx, settings):
                faults += [f"{compared.name}: {fault}" for fault in compared.faults]
                unread += [f"{compared.name}: {compared.unread}"] if compared.unread else []
    if as_json:
        print_json({"faults": faults, "not_compared": unread} if deep else {"faults": faults})
    else:
        for note in unread:
            console.print(f"not compared    {note}")
        for fault in faults:
            console.print(f"fault    {fault}")
        console.print("the store is sound" if not faults else f"{len(faults)} faults")
    if faults:
        raise typer.Exit(1)


def prune(
    older_than: Annotated[float, typer.Option(min=0, help="Days of history to keep")],
    yes: Annotated[bool, typer.Option("--yes", help="Delete them; without this option, list them")] = False,
    database: DatabaseOption = None,
    as_json: JsonOption = False,
) -> None:
    """Delete history: keep each document as it was a number of days ago, and all later revisions.

    Also delete activity older than MCML_ACTIVITY_DAYS.
    """
    settings = choose_settings(database)
    store = open_database(settings)
    pruned = prune_history(store, older_than, do=yes)
    if yes:
        forget_activity(store, settings.activity_days)
        from mcml_service.xpath.library.disk.part_file import forget

        forget(store, settings.cache_dir)
    if as_json:
        print_json({"pruned": yes, **asdict(pruned)})
        return
    room = f"{pruned.revisions:,} revisions of {pruned.documents:,} documents, {pruned.bytes / 1e6:,.1f} MB"
    console.print(f"forgot {room}" if yes else f"would forget {room}; --yes does it, and nothing brings them back")


def compact(
    yes: Annotated[bool, typer.Option("--yes", help="Also where it stops writers")] = False,
    database: DatabaseOption = None,
    as_json: JsonOption = False,
) -> None:
    """Return unused space to the disk, also while a server runs."""
    store = open_database(choose_settings(database))
    plan = store.dialect.compaction()
    if plan.stops_writers and not yes:
        raise McmlError(
            "This store can only be compacted as a whole, once: writers wait until it is done, "
            f"and it needs {plan.room / 1e6:,.0f} MB of room meanwhile (about {plan.room / 1e8:,.0f} s).",
            remedy="Run it with --yes. Afterwards it is done in small steps.",
        )
    freed = compact_store(store, lambda left: None if as_json else console.print(f"{left / 1e6:,.1f} MB to go"))
    if as_json:
        print_json({"bytes": freed})
    else:
        console.print(f"gave back {freed / 1e6:,.1f} MB")


def token_add(
    name: Annotated[str, typer.Argument(help="Name of the program; revisions record it")],
    days: Annotated[int, typer.Option(help="Days until it expires; 0: never")] = 90,
    scope: Annotated[
        Literal["read", "edit", "operate"], typer.Option(help="Permissions; operate: everything, including accounts")
    ] = "operate",
    account: Annotated[
        str | None, typer.Option(help="Owner: the token has no more permissions than this account")
    ] = None,
    project: Annotated[list[str] | None, typer.Option(help="Where alone it opens something; may be repeated")] = None,
    database: DatabaseOption = None,
) -> None:
    """Create a token. It is shown only once."""
    expires = None
    if days:
        expires = now(timedelta(days=days))
    with open_database(choose_settings(database)).write() as tx:
        owner = None if account is None else tx.accounts.get(account)
        projects = [tx.projects.get(name_of_project) for name_of_project in project or ()]
        secret = tx.tokens.add(name, expires, scope=scope, owner=owner, projects=projects)
    print(secret)
    console.print(
        f"curl -H 'Authorization: Bearer {secret}' …\nMCML_TOKEN={secret} mcml ls --server http://…", style="dim"
    )


def token_list(database: DatabaseOption = None, as_json: JsonOption = False) -> None:
    """List tokens: their names, first characters and dates."""
    with open_database(choose_settings(database)).read() as tx:
        tokens = tx.tokens.all()
    if as_json:
        print_json({"items": [vars(item) for item in tokens]})
        return
    rows = table("name", "begins with", "may", "in", "whose", "made", "expires", "used")
    for item in tokens:
        whose, expires, used = item.account or "", item.expires or "never", item.used or "never"
        where = ", ".join(item.projects) or "all"
        rows.add_row(item.name, item.hint + "…", item.scope, where, whose, item.created, expires, used)
    console.print(rows)


def token_revoke(name: Annotated[str, typer.Argument(help="Token")], database: DatabaseOption = None) -> None:
    """Revoke a token immediately."""
    with open_database(choose_settings(database)).write() as tx:
        tx.tokens.remove(name)
    console.print(f"revoked {name}")
