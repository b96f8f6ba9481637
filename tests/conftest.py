"""What tests share: stores of both kinds, a client, the real capture files."""

from __future__ import annotations

import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any, TypeAlias

# Before NumPy is imported. Tests run on all cores already: where several processes let BLAS take all of them too, its
# threads wait for each other, and a decomposition of a second takes ten.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# What tests of columns beside the store and of bodies ask for, they ask for.
os.environ.setdefault("MCML_CACHE_DIR", "none")
os.environ.setdefault("MCML_DERIVE", "no")

import pytest
from fastapi.testclient import TestClient
from hypothesis import HealthCheck, seed, settings

from mcml_service.actions.importing.load_demo import load_demo
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import fuzz, postgres
from tests.builders import served

StoreOf: TypeAlias = Callable[[str, Callable[[TestClient], Any]], tuple[TestClient, Any]]

settings.register_profile(
    "default",
    deadline=None,
    max_examples=20,
    derandomize=True,
    suppress_health_check=list(HealthCheck),
    print_blob=True,
)
settings.register_profile(
    "fuzz", deadline=None, max_examples=1000, suppress_health_check=list(HealthCheck), print_blob=True
)
settings.load_profile("default")


MEMORY = Path("/dev/shm")
ENOUGH_MEMORY = 6 << 30  # bytes


def pytest_configure(config: pytest.Config) -> None:
    # A fifth of the time of these tests goes to waiting for a disk, which tells nothing of the program.
    if "TMPDIR" not in os.environ and MEMORY.is_dir() and shutil.disk_usage(MEMORY).free > ENOUGH_MEMORY:
        os.environ["TMPDIR"] = tempfile.tempdir = str(MEMORY)
    if fuzz.asked_for(config):
        settings.load_profile("fuzz")


@pytest.fixture(autouse=True)
def own_process() -> Iterator[None]:
    """What a test, or a program that it runs here, sets in the environment and of the log is not the next one's."""
    before = dict(os.environ)
    root, ours = logging.getLogger(), logging.getLogger("mcml")
    levels, handlers = (root.level, ours.level), list(root.handlers)
    yield
    root.setLevel(levels[0])
    ours.setLevel(levels[1])
    for handler in [one for one in root.handlers if one not in handlers]:
        root.removeHandler(handler)
    # What pytest itself keeps there changes with the test.
    for name in {*before, *os.environ} - {"PYTEST_CURRENT_TEST"}:
        if name not in before:
            del os.environ[name]
        elif os.environ.get(name) != before[name]:
            os.environ[name] = before[name]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    # One more than processors: tests wait for browsers, databases and programs that they start.
    return (os.cpu_count() or 1) + 1


def pytest_report_header(config: pytest.Config) -> str:
    return f"the same seeds again: make fuzz SEED={fuzz.SEED}" if fuzz.asked_for(config) else ""


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    mark = metafunc.definition.get_closest_marker("fuzz")
    if mark is not None and "seeds" in mark.kwargs:
        count = mark.kwargs["seeds"] if fuzz.asked_for(metafunc.config) else 1
        metafunc.parametrize("seed", fuzz.seeds(metafunc.definition.nodeid, count))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    mark = item.get_closest_marker("fuzz")
    if report.when == "call" and report.failed and mark is not None and "seeds" in mark.kwargs:
        fuzz.keep(item.nodeid.partition("[")[0], item.callspec.params["seed"])  # type: ignore[attr-defined]
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("above_store") and _kind_of(item) == "postgresql":
            item.add_marker(pytest.mark.fuzz)
    if fuzz.asked_for(config):
        for item in items:
            if item.get_closest_marker("hypothesis"):
                seed(fuzz.SEED)(getattr(item.obj, "__func__", item.obj))  # type: ignore[attr-defined]
    else:
        long = [item for item in items if item.get_closest_marker("fuzz") is not None]
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item.get_closest_marker("fuzz") is None]


def _kind_of(item: pytest.Item) -> str | None:
    """The kind of database that a test is given, where it is given one."""
    given: str | None = item.callspec.params.get("kind") if hasattr(item, "callspec") else None
    return given


def shared_folder() -> Path | None:
    """The folder of real capture files, beside the repository or where MCML_SHARED says; None where it is absent."""
    stated = os.environ.get("MCML_SHARED")
    folder = Path(stated) if stated else Path(__file__).resolve().parents[2] / "shared"
    return folder / "data" if (folder / "data").is_dir() else None


@pytest.fixture(scope="session")
def shared() -> Path:
    folder = shared_folder()
    if folder is None:
        pytest.skip("the real capture files are not here (set MCML_SHARED to their folder)")
    return folder


@pytest.fixture(scope="session")
def postgres_server() -> Iterator[str]:
    # A server that does not start is a failure, not a skip: half of the store would go untested.
    with postgres.server() as address:
        yield address


@pytest.fixture(scope="session")
def sqlite_template(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("template") / "store.db"
    database = Database(f"sqlite:///{path}")
    database.migrate()
    database.close()
    return path


@pytest.fixture(scope="session")
def demo_library(sqlite_template: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A store with the demo library, to be copied."""
    path = tmp_path_factory.mktemp("library") / "library.db"
    shutil.copy(sqlite_template, path)
    database = Database(f"sqlite:///{path}")
    load_demo(database, Settings())
    database.close()
    return path


@pytest.fixture(scope="session")
def postgres_template(postgres_server: str) -> str:
    postgres.run(postgres_server, "CREATE DATABASE template_store")
    database = Database(postgres_server.format("template_store"))
    database.migrate()
    database.close()
    return postgres_server


@pytest.fixture(params=["sqlite", "postgresql"])
def kind(request: pytest.FixtureRequest) -> str:
    """The kinds of database, one after the other."""
    return str(request.param)


@pytest.fixture(scope="module")
def store_of(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[StoreOf]:
    """(kind, how it is filled) to the service on a store that the tests of a module share, which only read it."""
    with ExitStack() as stack:
        made: dict[str, tuple[TestClient, Any]] = {}

        def of(kind: str, fill: Callable[[TestClient], Any]) -> tuple[TestClient, Any]:
            if kind not in made:
                database = Database(stack.enter_context(_new_store(kind, tmp_path_factory.mktemp("store"), request)))
                stack.callback(database.close)
                client = stack.enter_context(served(database))
                made[kind] = client, fill(client)
            return made[kind]

        yield of


@contextmanager
def _new_store(kind: str, folder: Path, request: pytest.FixtureRequest) -> Iterator[str]:
    """The address of a new, empty store."""
    if kind == "sqlite":
        shutil.copy(request.getfixturevalue("sqlite_template"), folder / "store.db")
        yield f"sqlite:///{folder / 'store.db'}"
        return
    with postgres.new_database(request.getfixturevalue("postgres_template"), "template_store") as url:
        yield url


@pytest.fixture
def database_url(kind: str, request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[str]:
    """The address of a new, empty store."""
    with _new_store(kind, tmp_path, request) as url:
        yield url


@pytest.fixture
def database(database_url: str) -> Iterator[Database]:
    store = Database(database_url)
    yield store
    store.close()


@pytest.fixture
def limits() -> Settings:
    return Settings()


@pytest.fixture
def client(database: Database) -> Iterator[TestClient]:
    """The service on the store, asked in process."""
    with served(database) as client:
        yield client


@pytest.fixture(scope="session")
def workers() -> Iterator[Any]:
    """One worker, which starts with the first job: it takes longer to start than the jobs of tests take."""
    from mcml_service.jobs.host_workers import HostWorkers

    workers = HostWorkers(1, Settings().job_memory_mib << 20)
    yield workers
    workers.shutdown()


@pytest.fixture
def lent_workers(workers: Any) -> Iterator[None]:
    """Let servers that start from now on have their jobs run by the workers of all tests, which outlive them."""
    lent = SimpleNamespace(submit=workers.submit, kill=workers.kill, crew=workers.crew, shutdown=lambda: None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("mcml_service.jobs.runner.make_workers", lambda _database, _settings: lent)
        yield


@pytest.fixture
def quick_hashes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Hashes that take no second."""
    from pwdlib import PasswordHash
    from pwdlib.hashers.argon2 import Argon2Hasher

    from mcml_service import passwords

    quick = PasswordHash((Argon2Hasher(time_cost=1, memory_cost=64, parallelism=1),))
    monkeypatch.setattr(passwords, "_hasher", lambda: quick)
    passwords._nobodys.cache_clear()
