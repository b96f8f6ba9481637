"""The work of a worker: read clips from the store, run an analysis, return its parts.

It writes only the progress of its job.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from mcml.errors import McmlError
from mcml_service.actions.analysing.save_results import load_parts
from mcml_service.actions.analysing.start_analysis import EXTENDS, LEFT_OUT, SKELETON, check_parameters, find_analysis
from mcml_service.actions.checking.describe_problem import problem_of
from mcml_service.actions.composing.load_motions import Input, load_motions
from mcml_service.actions.composing.stored_trials import list_trials
from mcml_service.analysis.interface import Motion, Parts, Progress, TrialSource
from mcml_service.jobs.remote_motions import StoredMotions, Urls, database_of
from mcml_service.jobs.telling import Teller
from mcml_service.jobs.workers import Crew
from mcml_service.storage.core.views import WHOLE
from mcml_service.storage.database import Database

LOADING = 0.1
"""Share of the work that reading the clips counts for."""


@dataclass(frozen=True)
class Refused:
    """Clips or parameters did not fit; problem: as plain values."""

    problem: dict[str, Any]


Outcome = Parts | Refused


@dataclass(frozen=True)
class Task:
    """The description of a job for a worker. urls: of the store, and of its replica. runner: owner of the job."""

    urls: Urls
    uuid: str
    runner: str
    analysis: str
    inputs: list[dict[str, Any]]
    parameters: dict[str, Any]


def perform(
    database: Database,
    analysis: str,
    inputs: list[dict[str, Any]],
    parameters: dict[str, Any],
    progress: Progress,
    apart: Callable[[list[Input], Input | None], Sequence[Motion]] | None = None,
) -> Outcome:
    """Return the parts of the result, or the problem.

    apart: gives the clips, by inputs and skeleton, to an analysis that splits its work; None: all work is done here.
    Raises the errors of `progress`.
    """
    chosen = find_analysis(analysis)
    try:

        def loading(stage: str, share: float) -> None:
            progress(stage, LOADING * share)

        motions: Sequence[Motion | TrialSource]
        if chosen.reads == "trials":
            motions = list_trials(database, inputs)
        elif apart is not None and chosen.spreads:
            motions = apart(inputs, parameters.get(SKELETON))
        else:
            motions = database.ask(lambda tx: load_motions(tx, inputs, loading, parameters.get(SKELETON)))
        values = {name: value for name, value in parameters.items() if name not in (EXTENDS, LEFT_OUT, SKELETON)}
        # A job may have waited while the program, and with it what parameters may be, became another.
        checked = chosen.parameters.model_validate(check_parameters(chosen.parameters, values))

        def report(stage: str, share: float) -> None:
            progress(stage, LOADING + (1 - LOADING) * share)

        if EXTENDS not in parameters or chosen.extend is None:
            return chosen.run(motions, checked, report)
        parts = database.ask(lambda tx: load_parts(tx, tx.results.get(parameters[EXTENDS]).key))
        return chosen.extend(parts, motions, checked, report)
    except McmlError as error:
        return Refused(problem_of(error).model_dump(exclude_none=True))


def work_on(task: Task, crew: Crew) -> Outcome:
    """Perform a job in a worker process. crew: helpers. Raises CancelledError if the job is cancelled."""
    database = database_of(*task.urls)
    reader = database.for_call(WHOLE, from_replica=True)
    with Teller(database, task.uuid, task.runner) as tell:
        apart = partial(StoredMotions, task.urls, crew)
        return perform(reader, task.analysis, task.inputs, task.parameters, tell, apart)
