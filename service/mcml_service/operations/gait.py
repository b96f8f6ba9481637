"""Gait: of a document, and of several trials together, as numbers and as a report."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Literal, cast

from pydantic import Field

from mcml.answers import Content
from mcml_schemas.examples import DOCUMENT
from mcml_schemas.gait import (
    CalibratedTrials,
    FootOption,
    GaitComparison,
    GaitMeasures,
    StandingTrial,
    StandingTrialUse,
)
from mcml_service.operations.arguments import AtRevision, DocumentId, at_revision
from mcml_service.operations.call import Call
from mcml_service.operations.operation import gives

if TYPE_CHECKING:
    from mcml_service.actions.reading.compare_gait import Comparison
    from mcml_service.storage.documents.columns import Listed

Quantities = Annotated[
    list[str] | None,
    Field(
        max_length=40,
        description="Quantities to cut into cycles: NAME:JOINT,JOINT, angle:NAME or a measurement of the file",
        examples=[["angle:left-knee-flexion"]],
    ),
]
Events = Annotated[
    Literal["auto", "labels", "positions"],
    Field(description="Where strikes and offs come from: labels before force plates and positions, or one alone"),
]
Trials = Annotated[
    list[str],
    Field(
        min_length=1,
        max_length=50,
        description="Ids of documents, or collection:NAME; their strides count together",
        examples=[[DOCUMENT]],
    ),
]
Others = Annotated[
    list[str] | None,
    Field(max_length=50, description="Trials to compare with, such as another session", examples=[[DOCUMENT]]),
]
References = Annotated[
    list[str] | None,
    Field(
        max_length=50,
        description="Trials of the normal band: ids, or collection:NAME",
        examples=[["collection:healthy"]],
    ),
]


def get_gait(
    call: Call,
    id: DocumentId,
    revision: AtRevision = None,
    events: Annotated[
        Literal["auto", "labels", "positions"],
        Field(description="auto: labels such as left-foot-strike if there are any, else force plates and positions"),
    ] = "auto",
    subject: Annotated[
        str | None,
        Field(
            max_length=1024, description="Prefix of a person's markers, if there are several people", examples=["Anna"]
        ),
    ] = None,
    quantity: Quantities = None,
) -> GaitMeasures:
    """Events of both feet, strides, parameters with mean and standard deviation by side, and warnings
    (docs/analyses/gait.md). Lengths are in metres, null if the unit is unknown.

    The strikes, and the offs, of a side come from labels of the document if there are any, else from the positions of
    heels, toes and pelvis; steps on force plates have exact times. A `quantity` (docs/motion.md) is resampled from
    strike to strike to 101 values; quantities whose joints are of one side have cycles of that side. 422 if heels, toes
    or hips are unknown.
    """
    from mcml.motion.bodies.quantities import asked_quantity
    from mcml_service.actions.reading.read_gait import read_gait

    asked = [asked_quantity(text) for text in dict.fromkeys(quantity or ())]
    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        (body,) = call.queries.caches.bodies.read(then, [cast("Listed", stored)])
        return read_gait(then, stored, body, events, subject, asked)


def compare_gait(
    call: Call,
    document: Trials,
    compare: Others = None,
    reference: References = None,
    quantity: Quantities = None,
    events: Events = "auto",
) -> GaitComparison:
    """At most 50 documents in all. Means and standard deviations are of all strides of a group.

    Without `quantity`, cycles are those of a report: angles, moments and powers of the file's model, else of the model
    that is computed, else of the joints. A document whose gait cannot be measured says why and does not count.
    """
    from mcml_service.actions.reading.compare_gait import describe_comparison

    with _comparison(call, document, compare, reference, quantity, events) as comparison:
        return describe_comparison(comparison)


@gives("The report", {"application/pdf": None, "text/csv": None})
def get_gait_report(
    call: Call,
    document: Trials,
    compare: Others = None,
    reference: References = None,
    quantity: Quantities = None,
    events: Events = "auto",
    format: Annotated[
        Literal["pdf", "csv"],
        Field(description="PDF: pages to print; CSV: every cycle, one value a row", examples=["csv"]),
    ] = "pdf",
) -> Content:
    """The same numbers as `GET /gait`. PDF needs the extra `plots`: parameters by side, curves with mean and standard
    deviation, foot off, the normal band, the other trials as dashed lines, and warnings."""
    from mcml_service.actions.exporting.write_tables import About, batches_of, write_csv
    from mcml_service.actions.reading.compare_gait import COLUMNS, rows_of
    from mcml_service.actions.reading.draw_gait import draw_gait

    with _comparison(call, document, compare, reference, quantity, events) as comparison:
        name = f"{comparison.own.trials[0].name}-gait"
        if format == "csv":
            batches = batches_of(rows_of(comparison), COLUMNS)
            return Content(write_csv(batches, About()), "text/csv; charset=utf-8", f"{name}.csv")
        data = draw_gait(comparison)
    return Content(iter([data]), "application/pdf", f"{name}.pdf", size=len(data), shown=True)


def get_standing_trial(
    call: Call,
    id: DocumentId,
    foot: Annotated[
        FootOption | None,
        Field(description="flat sets the heel to the height of the toe; default: as stated offsets tell"),
    ] = None,
    subject: Annotated[
        str | None,
        Field(
            max_length=1024, description="Prefix of a person's markers, if there are several people", examples=["Anna"]
        ),
    ] = None,
    revision: AtRevision = None,
) -> StandingTrial:
    """Offsets of feet and wands, torsion of the tibia, and lengths, each with its source
    (docs/analyses/gait_model.md). 422 if nobody stands in the trial, or markers or measures are missing.
    """
    from mcml_service.actions.composing.standing_trials import describe_standing

    with call.database.read() as tx:
        then, stored = at_revision(tx, id, revision)
        return describe_standing(then, stored, foot, subject)


def use_standing_trial(call: Call, id: DocumentId, use: StandingTrialUse) -> CalibratedTrials:
    """Offsets replace those of the walking trials; their own measures of the body stay, and `notes` tells of
    differences. Each trial gets properties, such as `gait LThighRotation`, as one revision, which `undo` takes back.
    All trials are changed, or none.
    """
    from mcml_service.actions.composing.select_documents import select_documents
    from mcml_service.actions.composing.standing_trials import use_standing

    inputs, _ = select_documents(call.database, call.queries, use.selection)
    with call.database.write(call.author) as tx:
        items = use_standing(tx, tx.documents.get(id), [str(item["document"]) for item in inputs], use)
    return CalibratedTrials(items=items)


@contextmanager
def _comparison(
    call: Call,
    document: list[str],
    compare: list[str] | None,
    reference: list[str] | None,
    quantity: list[str] | None,
    events: Literal["auto", "labels", "positions"],
) -> Iterator[Comparison]:
    from mcml_service.actions.reading.compare_gait import compare_gait as compared

    with call.database.read() as tx:
        bodies = call.queries.caches.bodies
        yield compared(
            tx,
            lambda stored: bodies.read(tx, [cast("Listed", stored)])[0],
            document,
            compare,
            reference,
            quantity,
            events,
        )
