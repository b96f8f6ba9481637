"""docker-compose.yml without Docker: every command of it that is ours runs, with its environment, on ports of this
machine; a job is done by its worker, and what it lets Prometheus ask answers."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families
from sqlalchemy import make_url

from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import postgres
from tests.api.test_two_servers import is_ready, until
from tests.jobs.test_jobs import fill, start, wait

ROOT = Path(__file__).resolve().parents[2]
COMPOSE = (ROOT / "docker-compose.yml").read_text()
DOCKERFILE = (ROOT / "Dockerfile").read_text()
PROGRAMS = {
    "mcml": [sys.executable, "-m", "mcml_service.cli"],
    "dask": [sys.executable, "-m", "dask"],
    "python": [sys.executable],
}


class Machine:
    """What the file describes, on this machine. places: texts of the file, and what stands for them here."""

    def __init__(self, folder: Path, database: str) -> None:
        self.port, scheduler = postgres.free_port(), postgres.free_port()
        url = make_url(database)
        self.folder = folder
        self._places = {
            "${MCML_DB_PASSWORD}": "secret",
            "@database/mcml": f"@127.0.0.1:{url.port}/{url.database}",
            "scheduler:8786": f"127.0.0.1:{scheduler}",
            "0.0.0.0:8786": f"127.0.0.1:{scheduler}",
            "127.0.0.1:8000": f"127.0.0.1:{self.port}",
            "('127.0.0.1', 8786)": f"('127.0.0.1', {scheduler})",
            "/tmp": str(folder),
            "/home/mcml/cache": str(folder / "cache"),
        }
        self.services: dict[str, Any] = yaml.safe_load(COMPOSE)["services"]

    def here(self, said: str) -> str:
        for there, here in self._places.items():
            said = said.replace(there, here)
        assert not re.search(r"\$\{|@database|//scheduler", said), said
        return said

    def environment(self, service: str) -> dict[str, str]:
        image = dict(re.findall(r"(\w+)=(\S+)", "".join(re.findall(r"^ENV (.*)$", DOCKERFILE, re.MULTILINE))))
        assert image == {"MCML_HOST": "0.0.0.0", "MCML_PORT": "8000", "XDG_DATA_HOME": "/home/mcml/data"}
        here = {"MCML_HOST": "127.0.0.1", "MCML_PORT": str(self.port), "XDG_DATA_HOME": str(self.folder)}
        kept = {name: value for name, value in os.environ.items() if not name.startswith("MCML_")}
        given = {name: self.here(value) for name, value in self.services[service]["environment"].items()}
        return {**kept, "PYTHONPATH": str(ROOT), "MCML_DERIVE": "no", **here, **given}

    def run(self, service: str, command: list[str]) -> str:
        """What a command says to its end."""
        done = subprocess.run(
            self._words(command), env=self.environment(service), cwd=self.folder, capture_output=True, text=True,
            timeout=60,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    @contextmanager
    def up(self, *services: str) -> Iterator[None]:
        started = []
        try:
            for name in services:
                with (self.folder / name).open("wb") as log:
                    command = self._words(self.services[name]["command"])
                    given: dict[str, Any] = {"env": self.environment(name), "cwd": self.folder}
                    started.append(subprocess.Popen(command, stdout=log, stderr=log, **given))
            yield
        finally:
            for process in started:
                process.terminate()
            for process in started:
                process.wait(30)

    def _words(self, command: list[str]) -> list[str]:
        program, *words = command
        return [*PROGRAMS[program], *map(self.here, words)]


@pytest.fixture
def machine(postgres_server: str, tmp_path: Path) -> Iterator[Machine]:
    with postgres.new_database(postgres_server) as url:
        yield Machine(tmp_path, url)


@pytest.mark.fuzz
def test_what_it_starts_works_together(machine: Machine) -> None:
    said = re.findall(r"^#.* run --rm (\w+) (mcml .*?)(?: \||$)", COMPOSE, re.MULTILINE)
    assert [words.split()[1:3] for _, words in said] == [["db", "upgrade"], ["token", "add"]]
    for service, words in said:
        told = machine.run(service, shlex.split(words))
    token = told.splitlines()[0]
    store = Database(machine.environment("service")["MCML_DATABASE"])
    fill(store)
    with store.write() as tx:
        own = tx.tokens.add("kim", None)
    store.close()
    address = f"http://127.0.0.1:{machine.port}"
    with machine.up("scheduler", "worker", "service"):
        until(lambda: is_ready(address))
        (check,) = re.findall(r"CMD (\[\"python.*\])$", DOCKERFILE, re.MULTILINE)
        machine.run("service", json.loads(check))
        kind, *check = machine.services["scheduler"]["healthcheck"]["test"]
        assert kind == "CMD"
        machine.run("scheduler", check)
        with httpx.Client(base_url=address, headers={"authorization": f"Bearer {own}"}, timeout=60) as client:
            done = wait(client, start(client))  # type: ignore[arg-type]  # asks as the client of tests does
            assert done["state"] == "done", done
        scrape = yaml.safe_load((ROOT / "prometheus.yml").read_text())["scrape_configs"][0]
        assert scrape["static_configs"] == [{"targets": ["service:8000"]}]
        told = httpx.get(
            address + scrape["metrics_path"], headers={"authorization": f"Bearer {token}"}, timeout=60
        ).text
        families = {family.name: family for family in text_string_to_metric_families(told)}
        assert {"mcml_requests", "mcml_documents", "mcml_store_bytes"} <= set(families)
        assert sum(sample.value for sample in families["mcml_documents"].samples) == 12


def test_every_service_is_known() -> None:
    """A new one is started above, or is another's image."""
    services = yaml.safe_load(COMPOSE)["services"]
    assert set(services) == {"database", "service", "scheduler", "worker", "backup", "prometheus"}
    ours = {name for name, service in services.items() if "build" in service}
    assert ours == {"service", "scheduler", "worker", "backup"}
    assert json.loads(re.findall(r"^CMD (\[.*\])$", DOCKERFILE, re.MULTILINE)[-1]) == services["service"]["command"]
    assert services["scheduler"]["networks"] == services["database"]["networks"] == ["inside"]
    for mount in services["prometheus"]["volumes"][:1]:
        assert (ROOT / mount.partition(":")[0]).is_file()


def folders_of_the_image() -> set[str]:
    """That its user may write, so that a volume there is theirs."""
    before, _, after = DOCKERFILE.rpartition("USER mcml\n")
    assert before
    return {folder for made in re.findall(r"^RUN mkdir (.*)$", after, re.MULTILINE) for folder in made.split()}


def test_every_service_has_bounds_and_writes_where_it_may() -> None:
    found = yaml.safe_load(COMPOSE)
    for name, service in found["services"].items():
        assert re.fullmatch(r"\d+[mg]", service["mem_limit"]), name
        for volume in service.get("volumes", []):
            kept, place = volume.split(":")[:2]
            assert kept.startswith(".") or kept in found["volumes"], volume
            assert "build" not in service or place in folders_of_the_image(), volume
    assert found["services"]["service"]["environment"]["MCML_CACHE_DIR"] in folders_of_the_image()
    worker = found["services"]["worker"]
    assert int(re.findall(r"(\d+)GiB", " ".join(worker["command"]))[0]) < int(worker["mem_limit"].removesuffix("g"))
    assert "/healthz" in re.findall(r"^HEALTHCHECK .*\n.*$", DOCKERFILE, re.MULTILINE)[0]


def test_the_proxy_of_the_machine_is_trusted_and_nobody_else() -> None:
    """It comes through the bridge of the network that has a port outside."""
    found = yaml.safe_load(COMPOSE)
    (bridge,) = found["networks"]["outside"]["ipam"]["config"]
    service = found["services"]["service"]
    settings = Settings(trusted_proxies=service["environment"]["MCML_TRUSTED_PROXIES"])
    assert [str(network) for network in settings.proxies] == [f"{bridge['gateway']}/32"]
    assert all(port.startswith("127.0.0.1:") for port in service["ports"])
    assert found["networks"]["inside"]["internal"] is True


@pytest.mark.slow
def test_the_backup_job_keeps_a_copy_a_day(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its command, with a day that ends at once and a store of this machine."""
    shell, option, script = yaml.safe_load(COMPOSE)["services"]["backup"]["command"]
    store = Database(f"sqlite:///{tmp_path}/store.db")
    store.migrate()
    fill(store)
    store.close()
    (tmp_path / "backups").mkdir()
    monkeypatch.setenv("MCML_DATABASE", f"sqlite:///{tmp_path}/store.db")
    words = (
        f'mcml() {{ {shlex.quote(sys.executable)} -m mcml_service.cli "$@"; }}; sleep() {{ echo slept $1; exit; }}; '
    )
    command = [shell, option, words + script.replace("$$", "$")]
    given = os.environ | {"PYTHONPATH": str(ROOT)}
    for _ in range(2):
        done = subprocess.run(
            command, cwd=tmp_path / "backups", env=given, capture_output=True, text=True, check=False, timeout=60
        )
        assert "slept 86400" in done.stdout, done.stderr
        (kept,) = (tmp_path / "backups").iterdir()
        copy = Database(f"sqlite:///{kept}")
        assert copy.check() == []
        copy.close()
    given = os.environ | {"PYTHONPATH": str(ROOT), "MCML_DATABASE": "nonsense"}
    done = subprocess.run(command, cwd=tmp_path / "backups", env=given, capture_output=True, text=True, check=False)
    assert "slept 600" in done.stdout
    assert kept.exists(), "what was kept before stays where a new copy fails"
