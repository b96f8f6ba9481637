"""The command `mcml`: one file a command group."""

from __future__ import annotations

import io
import json
import os
import sys
from typing import NoReturn

import typer

from service.cli import (
    compose,
    elements,
    facts,
    files,
    frames,
    history,
    labels,
    library,
    names,
    querying,
    retarget,
    serving,
    store,
)
from service.cli.later import later
from service.errors import McmlError

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    help="Motion capture in one open XML language: convert, store, query.",
    epilog="Exit codes: 0 done, 1 refused or failed (the message says why), 2 wrong usage, 3 done in part.",
)
for module in (serving, files, library, facts, labels, elements, frames, history, compose, retarget, names, querying):
    module.add_to(app)
for name, about in (
    ("analyse", "Run analyses, and use what they found."),
    ("jobs", "Long work: list it, follow it, end it."),
):
    group = typer.Typer(cls=later(f"service.cli.{name}"), no_args_is_help=True, help=about)
    app.add_typer(group, name=name)
store.add_to(app)


def main() -> None:
    """The entry point: errors of ours become one message and exit code 1, never a traceback."""
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
        sys.exit(1)
    except BrokenPipeError:
        _leave_quietly()
    except SystemExit as end:
        # Typer and Rich take a closed pipe for a failure.
        if isinstance(end.__context__, BrokenPipeError):
            _leave_quietly()
        raise
    except OSError as error:
        print(f"mcml: {error.filename or 'the system'}: {error.strerror or error}", file=sys.stderr)
        sys.exit(1)


def _leave_quietly() -> NoReturn:
    """Whoever read the output, such as `head`, has seen enough."""
    # What is still buffered would fail again when Python ends.
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    sys.exit(0)
