"""`mcml gait`: the gait of one document, or of several trials together, and its report; `mcml standing-trial`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from mcml.client.choosing import id_of
from mcml.client.client import Client
from mcml.errors import RequestError
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    JsonOption,
    ServerOption,
    open_client,
    write_blocks,
)
from mcml_service.cli.terminal.present import present
from mcml_service.operations import OPERATIONS

_COLLECTION = "collection:"


def gait(
    ids: Annotated[
        list[str], typer.Argument(metavar="ID...", help="Documents, or collection:NAME", show_default=False)
    ],
    compare: Annotated[
        list[str] | None, typer.Option(help="Trial to compare with, such as of another session; may be repeated")
    ] = None,
    reference: Annotated[
        list[str] | None, typer.Option(help="Trial of the normal band, or collection:NAME; may be repeated")
    ] = None,
    quantity: Annotated[
        list[str] | None,
        typer.Option(help="Quantity to cut into cycles, such as angle:left-knee-flexion; may be repeated"),
    ] = None,
    events: Annotated[
        Literal["auto", "labels", "positions"],
        typer.Option(help="Where strikes and offs come from: labels before force plates and positions, or one alone"),
    ] = "auto",
    subject: Annotated[
        str | None, typer.Option(help="Prefix of a person's markers, if there are several people; of one document")
    ] = None,
    revision: Annotated[int | None, typer.Option(min=1, help="This revision of the document; of one document")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Write a report, .pdf, or every cycle, .csv")
    ] = None,
    force: ForceOption = False,
    as_json: JsonOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Measure gait: events, strides, parameters by side, and cycles of quantities.

    Several documents are measured together: means are of all their strides.
    """
    client = open_client(database, server)
    if len(ids) == 1 and not ids[0].startswith(_COLLECTION) and not compare and not reference and output is None:
        answer = client.call(
            "get_gait",
            id=id_of(client, ids[0]),
            events=events,
            subject=subject,
            revision=revision,
            quantity=quantity or None,
        )
        present(OPERATIONS["get_gait"], answer, as_json)
        return
    if subject is not None or revision is not None:
        raise RequestError(
            "--subject and --revision are of one document.", remedy="Leave them out, or name one document alone."
        )
    trials = {"document": ids, "compare": compare, "reference": reference}
    asked: dict[str, Any] = {name: _ids_of(client, texts) for name, texts in trials.items() if texts}
    if output is None:
        answer = client.call("compare_gait", **asked, quantity=quantity or None, events=events)
        present(OPERATIONS["compare_gait"], answer, as_json)
        return
    form = output.suffix.removeprefix(".").lower()
    if form not in ("pdf", "csv"):
        raise RequestError(f"{output} is no report by its name.", remedy="End it in .pdf, or .csv for every cycle.")
    answer = client.call("get_gait_report", **asked, quantity=quantity or None, events=events, format=form)
    write_blocks(answer.blocks, output, force=force)


def standing_trial(
    standing: Annotated[str, typer.Argument(metavar="STANDING", help="The standing trial", show_default=False)],
    trials: Annotated[
        list[str] | None,
        typer.Argument(metavar="[TRIAL...]", help="Walking trials, or collection:NAME", show_default=False),
    ] = None,
    foot: Annotated[
        Literal["flat", "as it stands"] | None,
        typer.Option(help="flat sets the heel to the height of the toe; default: as stated offsets tell"),
    ] = None,
    subject: Annotated[str | None, typer.Option(help="Prefix of a person's markers, if there are several")] = None,
    as_json: JsonOption = False,
    database: DatabaseOption = None,
    server: ServerOption = None,
) -> None:
    """Show the measures that a standing trial gives to walking trials, or give them to these trials.

    Each walking trial gets properties, such as `gait LThighRotation`, as one revision; `undo` takes it back.
    """
    client = open_client(database, server)
    id = id_of(client, standing)
    if not trials:
        answer = client.call("get_standing_trial", id=id, foot=foot, subject=subject)
        present(OPERATIONS["get_standing_trial"], answer, as_json)
        return
    use = {"selection": {"documents": _ids_of(client, trials)}, "foot": foot, "subject": subject}
    answer = client.call("use_standing_trial", id=id, use=use)
    present(OPERATIONS["use_standing_trial"], answer, as_json)


def _ids_of(client: Client, texts: list[str]) -> list[str]:
    return [text if text.startswith(_COLLECTION) else id_of(client, text) for text in texts]
