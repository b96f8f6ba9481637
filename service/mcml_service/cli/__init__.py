"""The command `mcml`: most of it made from OPERATIONS (`commands.py`), the rest by hand, as BY_HAND lists it."""

from __future__ import annotations

import io
import json
import os
import sys
from typing import Annotated, NoReturn

import typer

from mcml.errors import McmlError, RequestError, is_full
from mcml_service.cli.commands import command_of
from mcml_service.cli.terminal.collector import collect_again, spare_what_stays
from mcml_service.cli.terminal.lazily import from_module, lazy_command, lazy_group
from mcml_service.operations import OPERATIONS

BY_HAND = {
    "serve": "serving:serve",
    "demo": "serving:demo",
    "doctor": "serving:doctor",
    "convert": "files:convert",
    "validate": "files:validate",
    "import": "importing:import_",
    "sync": "syncing:sync",
    "export": "exporting:export",
    "xpath": "querying:xpath",
    "search": "searching:search",
    "label": "edits.labels:label",
    "set": "edits.documents:set_",
    "rename": "edits.documents:rename",
    "move": "edits.documents:move",
    "delete": "edits.documents:delete",
    "purge": "edits.purging:purge",
    "frames": "edits.frames:frames",
    "numbers": "numbers:numbers",
    "analog": "numbers:analog",
    "arrays": "numbers:arrays",
    "gait": "gait:gait",
    "standing-trial": "gait:standing_trial",
    "measure": "measuring:measure",
    "compose": "edits.composing:compose",
    "retarget": "edits.composing:retarget",
    "follow": "edits.matching:follow",
    "labels suggest": "edits.labels:suggest",
    "element set": "edits.elements:set_",
    "element move": "edits.elements:move",
    "mapping save": "edits.names:save",
    "mapping alias": "edits.names:alias",
    "names apply": "edits.names:apply",
    "names set": "edits.names:set_names",
    "db upgrade": "store:upgrade",
    "db backup": "store:backup_",
    "db restore": "store:restore_",
    "db check": "store:check",
    "db derive": "deriving:derive",
    "db prune": "store:prune",
    "db compact": "store:compact",
    "account invite": "accounts:invite",
    "account add": "accounts:add",
    "account password": "accounts:password",
    "account role": "accounts:role",
    "account close": "accounts:close",
    "account reopen": "accounts:reopen",
    "project copy": "moving:copy",
    "project archive": "moving:archive",
    "project open": "moving:open_",
    "project quota": "moving:quota",
    "project review": "moving:review",
    "project export": "moving:export",
    "project import": "moving:import_",
    "project vocabulary": "edits.names:vocabulary",
    "project add": "accounts:add_member",
    "share add": "accounts:share",
    "webhook add": "webhooks:add",
    "token add": "store:token_add",
    "token list": "store:token_list",
    "token revoke": "store:token_revoke",
}
"""Commands that are no operation, many of them, or shorter to type than one; and where each is."""

GROUPS = {
    "labels": "Labels of documents, by query, as tables; and from the motion.",
    "comment": "Comments on documents, their frames and joints.",
    "proposal": "Proposed changes of documents: create, review, apply.",
    "element": "Elements of a document, addressed by XPath. An edit is a revision.",
    "mapping": "Saved joint mappings between rigs, and the joint names of projects.",
    "names": "Names of joints of documents that exist.",
    "running": "Running queries of a server: list and cancel.",
    "jobs": "Long work: list it, follow it, end it.",
    "analyse": "Run analyses, and use what they found.",
    "db": "Upgrade, back up, restore and check the store.",
    "account": "Accounts of people, their roles, and invitations.",
    "project": "Members of projects, their roles and quotas.",
    "share": "Links by which people without an account see some documents.",
    "webhook": "Addresses that a server tells of events.",
    "token": "Tokens that open a server to programs and other machines.",
}

MODULES = {"analyse": "mcml_service.cli.analyse", "jobs": "mcml_service.cli.jobs"}
"""Groups made by a module, from the catalogue of analyses."""


def _make_app() -> typer.Typer:
    made = typer.Typer(
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        help="Motion capture in one open XML language: convert, store, query.",
        epilog="Exit codes: 0 done, 1 refused or failed (the message says why), 2 wrong usage, 3 done in part.",
    )
    made.callback()(_options)
    groups = {name: typer.Typer(no_args_is_help=True, help=about) for name, about in GROUPS.items()}

    def place(words: list[str]) -> typer.Typer:
        return made if len(words) == 1 else groups[words[0]]

    for name, address in BY_HAND.items():
        words = name.split()
        place(words).command(words[-1], cls=lazy_command(from_module(address)))(_nothing)
    for operation in OPERATIONS.values():
        words = [word for word in (operation.command or "").split() if word == word.lower()]
        if words and words[0] not in MODULES:
            command = lazy_command(command_of(operation))
            place(words).command(words[-1], cls=command, short_help=operation.words)(_nothing)
    for name, group in groups.items():
        # A group of one command would else lose its name.
        group.callback(help=GROUPS[name])(_nothing)
        made.add_typer(group, name=name, cls=lazy_group(MODULES[name]) if name in MODULES else None)
    return made


def _nothing() -> None:
    """A placeholder for a command that is made later."""


def _version(wanted: bool) -> None:
    if wanted:
        from mcml.resources import program_version

        print(program_version())
        raise typer.Exit


def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and end")
    ] = False,
) -> None:
    """Motion capture in one open XML language: convert, store, query."""


app = _make_app()
collect_again()


def main() -> None:
    """The entry point: errors of this program become one message and exit code 1 (2: wrong usage), never a
    traceback.
    """
    spare_what_stays()
    if isinstance(sys.stdout, io.TextIOWrapper):
        # A terminal that cannot show a name, such as a Korean one in the C locale, is no reason to fail.
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            app()
        finally:
            sys.stdout.flush()
    except McmlError as error:
        where = f"{error.at}: " if error.at and str(error.at) else ""
        print(f"mcml: {where}{error.what}", file=sys.stderr)
        if error.remedy:
            print(f"      {error.remedy}", file=sys.stderr)
        if "code" in error.details:
            print(f"      {json.dumps(error.details, default=str, ensure_ascii=False)}", file=sys.stderr)
        sys.exit(2 if isinstance(error, RequestError) else 1)
    except BrokenPipeError:
        _leave_quietly()
    except SystemExit as end:
        # Typer and Rich take a closed pipe for a failure.
        if isinstance(end.__context__, BrokenPipeError):
            _leave_quietly()
        raise
    except OSError as error:
        print(f"mcml: {error.filename or 'the system'}: {error.strerror or error}", file=sys.stderr)
        if is_full(error):
            print("      Make room on that disk, then run the command again.", file=sys.stderr)
        sys.exit(1)


def _leave_quietly() -> NoReturn:
    """The reader of the output, such as `head`, has ended."""
    # Buffered output would fail again when Python ends.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(0)
