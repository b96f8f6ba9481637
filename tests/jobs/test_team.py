"""A team's Dask: a scheduler and workers of their own, over TLS with certificates that the test makes."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path
from typing import Any

import dask
import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from mcml.errors import StoreError
from mcml_service.jobs.dask_workers import DaskWorkers
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests import postgres
from tests.builders import served
from tests.jobs import works
from tests.jobs.test_jobs import API, fill, instead, start, wait

FILES = ("ca.pem", "cert.pem", "key.pem")


def make_certificates(folder: Path) -> None:
    """One that signs, and one that it signed for everybody in the cluster, with its key."""
    authority, own = (ec.generate_private_key(ec.SECP256R1()) for _ in range(2))
    issuer = _name("authority")
    ca = _certificate(issuer, issuer, authority, authority, is_authority=True)
    certificate = _certificate(_name("cluster"), issuer, own, authority, is_authority=False)
    key = own.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    pem = serialization.Encoding.PEM
    for name, content in zip(FILES, (ca.public_bytes(pem), certificate.public_bytes(pem), key), strict=True):
        (folder / name).write_bytes(content)


def _name(name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])


def _certificate(
    subject: x509.Name, issuer: x509.Name, key: Any, signs: Any, *, is_authority: bool
) -> x509.Certificate:
    began = datetime.now(UTC) - timedelta(days=1)
    made = x509.CertificateBuilder().subject_name(subject).issuer_name(issuer).public_key(key.public_key())
    made = made.serial_number(x509.random_serial_number()).not_valid_before(began)
    made = made.not_valid_after(began + timedelta(days=3))
    made = made.add_extension(x509.BasicConstraints(ca=is_authority, path_length=None), critical=True)
    return made.sign(signs, hashes.SHA256())


@contextmanager
def running(folder: Path, *words: str) -> Iterator[None]:
    """A program of Dask, with the certificates of the folder."""
    names = ("--tls-ca-file", "--tls-cert", "--tls-key")
    files = [word for name, file in zip(names, FILES, strict=True) for word in (name, str(folder / file))]
    given = {**os.environ, "PYTHONPATH": os.getcwd(), "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0"}
    with (folder / "log").open("ab") as log:
        program = subprocess.Popen(
            [sys.executable, "-m", "dask", *words, *files, "--no-dashboard"],
            env=given, cwd=folder, stdout=log, stderr=log,
        )  # fmt: skip
    try:
        yield
    finally:
        program.terminate()
        program.wait(30)


@pytest.fixture
def team(tmp_path: Path) -> Iterator[Settings]:
    """Settings of a server whose jobs two workers do."""
    make_certificates(tmp_path)
    port = str(postgres.free_port())
    address = f"tls://127.0.0.1:{port}"
    with ExitStack() as stack:
        stack.enter_context(running(tmp_path, "scheduler", "--host", address, "--port", port))
        for _ in range(2):
            stack.enter_context(running(tmp_path, "worker", address, "--nthreads", "1", "--no-nanny"))
        ca, cert, key = (str(tmp_path / file) for file in FILES)
        yield Settings(dask_scheduler=address, dask_tls_ca=ca, dask_tls_cert=cert, dask_tls_key=key, job_workers=2)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["postgresql"], indirect=True)
def test_a_team_does_jobs_over_tls_and_loses_none_with_a_worker(
    database: Database, team: Settings, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    fill(database)
    with served(database, team) as server:
        done = wait(server, start(server))
        assert done["state"] == "done", done
        with monkeypatch.context() as patch:
            instead(patch, partial(works.dying, 1, str(tmp_path / "marks")))
            done = wait(server, start(server))
            assert done["state"] == "done", done
        assert server.get(f"{API}/results/{done['result']}/numbers").json()["data"] == {"value": 1}
        # The worker that is left.
        assert wait(server, start(server))["state"] == "done"
    # Who has certificates of somebody else does not come in.
    others = tmp_path / "others"
    others.mkdir()
    make_certificates(others)
    ca, cert, key = (str(others / file) for file in FILES)
    foreign = Settings(dask_scheduler=team.dask_scheduler, dask_tls_ca=ca, dask_tls_cert=cert, dask_tls_key=key)
    with dask.config.set({"distributed.comm.timeouts.connect": "2s"}), pytest.raises(OSError, match="certificate"):
        DaskWorkers(database, foreign).submit(len, "")


@pytest.mark.parametrize("kind", ["postgresql"], indirect=True)
def test_what_is_missing_for_tls_is_said_at_once(database: Database, tmp_path: Path) -> None:
    for file in (None, str(tmp_path / "none.pem")):
        settings = Settings(dask_scheduler="tls://dask:8786", dask_tls_ca=file)
        with pytest.raises(StoreError, match="certificates"):
            DaskWorkers(database, settings)


def test_no_more_jobs_of_a_project_run_than_may(database: Database) -> None:
    with database.write() as tx:
        labs = [tx.projects.get_or_add(name) for name in ("lab", "lab", "lab", "studio")]
        jobs = [tx.jobs.add(lab, "reach", "a model", "kim", [], {}) for lab in labs]
    taken = []
    for _ in range(4):
        with database.write() as tx:
            taken += [job.uuid for job in tx.jobs.claim("runner", 1, of_project=2)]
    assert taken == [jobs[0], jobs[1], jobs[3]]
    with database.write() as tx:
        assert not tx.jobs.any_claimable(2)
        tx.jobs.end(jobs[1], "runner", "done")
        assert [job.uuid for job in tx.jobs.claim("runner", 1, of_project=2)] == [jobs[2]]
