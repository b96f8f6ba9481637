"""Store the output of a job: parts of a result, and clips as documents."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version

from mcml_service.actions.editing.whole_document import add_labels
from mcml_service.actions.importing.store_clip import store_clip
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.analysis.interface import Part, Parts
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from mcml_service.storage.transaction import Transaction
from mcml_service.storage.work.jobs import StoredJob

LABELS = "labels"
"""The part whose rows become motion names of the documents that were read."""

LIBRARIES = ("mcml-repository", "numpy", "scipy")


def save_results(database: Database, settings: Settings, job: StoredJob, runner: str, parts: Parts) -> str:
    """Keep the parts and end the job, in one transaction; answers the result's uuid.

    Clips are stored as documents before. Should the process die in between, the job runs again and finds them: they
    name the job they came from, so their bytes are the same. ConflictError where the job is another runner's by now.
    """
    provenance = {"analysis": job.analysis, "job": job.uuid, "sources": job.inputs, "parameters": job.parameters}
    documents = {
        name: store_clip(
            database,
            part.clip,
            settings,
            project=job.project,
            author=job.owner,
            provenance=provenance | {"part": name},
            once=True,
        )
        for name, part in parts.items()
        if part.clip is not None
    }
    with database.write(job.owner) as tx:
        if LABELS in parts:
            parts = {**parts, LABELS: write_labels(tx, parts[LABELS], job)}
        parent = job.parameters.get("extends")
        inputs = [*(tx.results.get(parent).inputs if parent else ()), *job.inputs]
        key, uuid = tx.results.add(
            job.project_key,
            job.analysis,
            job.name,
            job.owner,
            inputs,
            job.parameters,
            list_versions(job.analysis),
            parent,
        )
        add_parts(tx, key, parts, documents)
        tx.jobs.end(job.uuid, runner, "done", result_key=key)
    return uuid


def write_labels(tx: Transaction, part: Part, job: StoredJob) -> Part:
    """Label frames of the input documents by the rows (document, name, first, last) of the part.

    A document that was edited since may have other frames: it is skipped, and listed in the part.
    """
    wanted: dict[str, list[tuple[str, int, int]]] = {}
    for uuid, name, first, last in part.data["rows"]:
        wanted.setdefault(uuid, []).append((name, first, last))
    read = {item["document"]: item["revision"] for item in job.inputs}
    written, left = [], []
    for uuid, labels in wanted.items():
        stored = tx.documents.find(uuid)
        if stored is not None:
            tx.documents.lock(stored.key)
            stored = tx.documents.find(uuid)
        if stored is None or stored.revision != read[uuid]:
            left.append(uuid)
            continue
        add_labels(tx, stored, labels)
        written.append(uuid)
    return replace(part, data={**part.data, "written": written, "edited_meanwhile": left})


def add_parts(tx: Transaction, key: int, parts: Parts, documents: Mapping[str, str]) -> None:
    """Write the parts of a result. documents: uuid of the document of each part that is a clip."""
    for name, part in parts.items():
        document_key = tx.documents.get(documents[name]).key if name in documents else None
        tx.results.add_part(key, name, part.kind, part.data, part.arrays, document_key)


def load_parts(tx: Transaction, key: int) -> Parts:
    """Load the parts of a result, without clips."""
    return {
        part.name: Part(
            part.kind,  # type: ignore[arg-type]  # the column holds nothing else
            part.data,
            {name: tx.results.array(key, part, name) for name in part.arrays},
        )
        for part in tx.results.parts(key)
    }


def list_versions(analysis: str) -> dict[str, str]:
    """Versions of the libraries, and of the rules of an analysis."""
    versions = {f"rule {name}": number for name, number in ANALYSES[analysis].rules.items()}
    for library in LIBRARIES:
        try:
            versions[library] = version(library)
        except PackageNotFoundError:
            versions[library] = "checkout"
    return versions
