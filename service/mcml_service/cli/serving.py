"""`mcml serve`, `mcml demo`, `mcml doctor`."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import socket
import sqlite3
import sys
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.text import Text

from mcml.errors import McmlError
from mcml.files.on_disk import write_file
from mcml.resources import dtd_path
from mcml_service.cli.terminal.opening import (
    DatabaseOption,
    ForceOption,
    ServerOption,
    choose_settings,
    console,
    find_database,
    open_client,
    upgrade_database,
)
from mcml_service.resources import migrations_path
from mcml_service.settings import unknown_variables
from mcml_service.storage.lists.filtering import DocumentFilter

OPEN = "Open to everything on this machine, a proxy included, until the first account or token is made"

KEPT_SECONDS = 75
"""Idle timeout of a connection.

It is longer than that of proxies and clients (usually 60 s), because a request sent just as the server closes the
connection gets no answer. If there are too many connections, the one idle longest is closed.
"""


def serve(
    host: Annotated[
        str | None, typer.Option(help="Address to listen on; other than loopback needs an account or a token")
    ] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on")] = None,
    database: DatabaseOption = None,
    workers: Annotated[int, typer.Option(min=1, help="Processes that serve; they share the machine's cores")] = 1,
    with_demo: Annotated[bool, typer.Option("--demo", help="Load the demo library if the store is empty")] = False,
) -> None:
    """Serve the repository over HTTP."""
    # Imported late: other commands need not wait for the web.
    import uvicorn

    from mcml_service.api.admission import share_heaps
    from mcml_service.api.authentication import why_closed
    from mcml_service.api.connections import BACKLOG, connections_of
    from mcml_service.api.logs import keep_log

    for fault in unknown_variables(os.environ):
        console.print(Text(f"mcml: {fault}", style="yellow"))
    settings = choose_settings(database, port=port)
    settings = settings.model_copy(update={"host": host or settings.host})
    _check_port(settings.host, settings.port)
    store = upgrade_database(settings)
    if with_demo:
        with store.read() as tx:
            empty = not tx.documents.page(DocumentFilter(), after=None, limit=1)
        if empty:
            from mcml_service.actions.importing.load_demo import load_demo

            load_demo(store, settings)
    reason = why_closed(settings, store)
    with store.read() as tx:
        has_people = tx.accounts.exist()
        has_owner = tx.accounts.have_owner()
        has_token = tx.tokens.exist()
    link = None
    if reason or has_token or has_people:
        with store.write() as tx:
            link = tx.sessions.link("local")
    store.close()
    name = f"[{settings.host}]" if ":" in settings.host else settings.host
    console.print(Text.assemble("MCML Repository on ", (f"http://{name}:{settings.port}/", "bold"), "  (Ctrl+C stops)"))
    console.print(Text("Closed: requests need an account or a token." if link else OPEN, style="dim"))
    if link:
        words = "opens it once in a browser" if has_owner else "opens it once in a browser, to make the first account"
        console.print(f"This link {words}:  http://{name}:{settings.port}/login?link={link}")
    os.environ["MCML_HOST"], os.environ["MCML_PORT"] = settings.host, str(settings.port)
    os.environ["MCML_DATABASE"] = settings.database_url
    keep_log(settings)
    share_heaps()
    if workers > 1:
        os.environ["MCML_JOB_WORKERS"] = str(max(1, settings.jobs_at_a_time // workers))
        os.environ["MCML_HEAVY_PLACES"] = str(max(2, settings.heavy_at_once // workers))
        os.environ["MCML_IMPORT_PROCESSES"] = str(max(1, settings.import_processes_at_a_time // workers))
    uvicorn.run(
        "mcml_service.cli.serving:app_of_a_worker" if workers > 1 else "mcml_service.app:app_from_environment",
        factory=True,
        workers=workers,
        host=settings.host,
        port=settings.port,
        http=connections_of(settings),  # type: ignore[arg-type]  # any factory
        backlog=BACKLOG,
        log_config=None,
        access_log=False,
        timeout_graceful_shutdown=settings.stop_seconds,
        timeout_keep_alive=KEPT_SECONDS,
        # The service reads such headers itself, of proxies that it trusts.
        proxy_headers=False,
    )


def app_of_a_worker() -> Any:
    """The service in one of several processes, each of which keeps the log."""
    from mcml_service.api.admission import share_heaps
    from mcml_service.api.logs import keep_log
    from mcml_service.app import app_from_environment

    share_heaps()
    keep_log(choose_settings())
    return app_from_environment()


def _check_port(host: str, port: int) -> None:
    """McmlError where nothing can listen there."""
    if not 0 <= port <= 65535:
        raise McmlError(f"{port} is no port.", remedy="Ports are 0 to 65535.")
    try:
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        with socket.create_server((host, port), family=family):
            pass
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise McmlError(
            f"Nothing can listen at {host}:{port}: {why}.", remedy="Choose another with --port, or end what uses it."
        ) from None


def demo(
    database: DatabaseOption = None,
    server: ServerOption = None,
    seed: Annotated[int, typer.Option(min=0, max=1_000_000, help="Another seed makes other clips")] = 1,
    project: Annotated[str | None, typer.Option(help="Project for all clips; default demo, demo-reach, …")] = None,
    files: Annotated[
        Path | None, typer.Option(help="Instead: write walk.bvh, reach.asf and reach.amc into this folder, to try with")
    ] = None,
    force: ForceOption = False,
) -> None:
    """Add a small library of generated clips: walks, reaches, dances, faces, with their motion names and properties."""
    from mcml_service.actions.importing.load_demo import PROJECTS, demo_files

    if files is not None:
        for name, content in demo_files(seed).items():
            write_file(files / name, [content], force=force)
            console.print(f"wrote    {files / name}")
        return
    client = open_client(database, server)
    for part in PROJECTS:
        # One part at a time, so that each is a short request to a server.
        loaded = client.call("load_demo", part=[part], seed=seed, project=project).parts[0]
        existing = f", {loaded.existing} existed" if loaded.existing else ""
        console.print(f"{loaded.project}: {loaded.stored} clips stored{existing}")


EXTRAS = {
    "7z": "py7zr",
    "arrow": "pyarrow",
    "audio": "librosa",
    "gltf": "pygltflib",
    "openid": "authlib",
    "plots": "matplotlib",
    "usd": "pxr",
}
"""Optional extras of the program, each with one of its modules."""


def doctor(
    database: DatabaseOption = None,
    project: Annotated[
        str | None,
        typer.Option(help="Check only documents of this project for names that an import would now read differently"),
    ] = None,
) -> None:
    """Check this installation: list its parts, missing parts, and how to install them."""
    from mcml_service.cli.differing import tell_differing
    from mcml_service.clips.bodies import MADE
    from mcml_service.storage.core.replica import Replica
    from mcml_service.xpath.library.caches import Caches
    from mcml_service.xpath.library.disk.part_file import path_of, why_not
    from mcml_service.xpath.library.disk.sidecar import Sidecar
    from mcml_service.xpath.library.preparing import count_prepared

    settings = choose_settings(database)
    faults = 0

    def line(what: str, fact: str, good: bool = True, remedy: str = "") -> None:
        nonlocal faults
        faults += not good
        console.print(f"{'ok  ' if good else 'LACK'} {what:<16} {fact}" + (f"\n     {remedy}" if remedy else ""))

    line(
        "python",
        platform.python_version(),
        sys.version_info >= (3, 11),
        "" if sys.version_info >= (3, 11) else "Use 3.11+.",
    )
    line("sqlite", sqlite3.sqlite_version)
    for fault in unknown_variables(os.environ):
        name, _, told = fault.partition(" ")
        line("environment", f"{name} {told.partition('. ')[0]}", False, told.partition(". ")[2])
    line("mcml.dtd", str(dtd_path()))
    line("migrations", str(migrations_path()))
    for module, need in (("pcodec", True), ("simdjson", False), ("psycopg", False)):
        is_installed = importlib.util.find_spec(module) is not None
        line(module, "installed" if is_installed else "not installed", is_installed or not need)
    for extra, module in EXTRAS.items():
        there = importlib.util.find_spec(module) is not None
        line(f"extra {extra}", "installed" if there else f"not installed: pip install 'mcml-repository[{extra}]'")
    store = find_database(settings)
    address = store.dialect.engine.url.render_as_string(hide_password=True)
    try:
        version, wanted = store.schema_versions()
    except Exception as error:  # any driver's own error: the doctor reports it and continues
        line("store", f"{address}: {error}", False, "Check the address and that the server runs.")
    else:
        line("store", address)
        try:
            store.require_schema()
        except McmlError as error:
            line("schema", error.what, False, error.remedy or "")
        else:
            line("schema", f"{version} of {wanted}")
            sizes = store.size()
            with store.read() as tx:
                count, missing = tx.documents.count(DocumentFilter()), len(tx.bodies.without(MADE))
            line(
                "documents",
                f"{count:,} in {sizes['total'] / 1e6:,.1f} MB, {sizes['uploads'] / 1e6:,.1f} MB of it uploads",
            )
            if settings.database_read_url:
                behind = Replica(settings.database_read_url, store.dialect).behind()
                away = "Servers read the primary meanwhile. Look whether it runs, and MCML_DATABASE_READ_URL."
                fact = "unreachable" if behind is None else f"{behind:,} bytes behind"
                line("replica", fact, behind is not None, away if behind is None else "")
            way = "A server derives the others" if settings.derive else "Derive the others"
            line(
                "bodies",
                f"{count - missing:,} of {count:,} documents have theirs",
                remedy=f"{way}: mcml {'serve, or mcml ' * settings.derive}db derive." if missing else "",
            )
            with store.read() as tx:
                listed = len(tx.documents.uuids(DocumentFilter(project=project)))
            tell_differing(store, project, listed)
            place = path_of(store, settings.cache_dir)
            trouble = "" if place is None else why_not(place)
            if place is None:
                line("query columns", "in memory only: MCML_CACHE_DIR is none")
            else:
                remedy = "Queries use memory alone. Make the folder writable, or name one in MCML_CACHE_DIR."
                fact = f"{place}: {trouble}"
                if not trouble:
                    built, groups = count_prepared(store, Caches(sidecar=Sidecar(place, settings.cache_disk_mib << 20)))
                    size = f"{place.stat().st_size / 1e6:,.1f} MB in {place}"
                    fact = f"{size}, built for {built} of {groups} groups of documents"
                    remedy = "A server builds the others, or: mcml db derive." if built < groups else ""
                line("query columns", fact, not trouble, remedy)
    path = settings.database_url.removeprefix("sqlite:///")
    if path != settings.database_url:
        folder = os.path.dirname(path) or "."
        if os.path.isdir(folder):
            free = shutil.disk_usage(folder).free
            line("free disk", f"{free / 1e9:,.1f} GB", free > 1e9, "" if free > 1e9 else "Make room.")
    if faults:
        raise typer.Exit(1)
