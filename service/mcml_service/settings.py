"""Settings: the only reader of the environment. Made once by `app` or `cli` and passed on."""

from __future__ import annotations

import ipaddress
import os
import sys
from collections.abc import Iterable
from contextlib import suppress
from difflib import get_close_matches
from importlib.util import find_spec
from pathlib import Path
from typing import Literal
from urllib.parse import urlsplit

from pydantic import Field, field_validator
from pydantic_settings import BaseSettings, SettingsConfigDict

from mcml.files.limits import FileLimits

MIB = 1 << 20


def data_folder() -> Path:
    """The user's data folder for this program (XDG on Linux, the platform's own elsewhere)."""
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Application Support" / "mcml"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", str(Path.home()))) / "mcml"
    return Path(os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share") / "mcml"


def cache_folder() -> Path:
    """Return the user's cache folder (XDG on Linux, the platform's own elsewhere)."""
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "mcml"
    if sys.platform == "win32":
        return data_folder() / "cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mcml"


def private_folder(folder: Path) -> Path:
    """Return the folder, created if missing; only its owner can read the data folder."""
    folder.mkdir(parents=True, exist_ok=True)
    if folder == data_folder() and os.name == "posix":
        # It may be another user's.
        with suppress(OSError):
            folder.chmod(0o700)
    return folder


def is_loopback(host: str) -> bool:
    """Whether a host name or address (without port) means this machine."""
    name = host.strip("[]").rstrip(".").lower()
    if name == "localhost" or name.endswith(".localhost"):
        return True
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return False


def _networks_in(text: str) -> list[ipaddress.IPv4Network | ipaddress.IPv6Network]:
    return [ipaddress.ip_network(part.strip(), strict=False) for part in text.split(",") if part.strip()]


OTHERS = frozenset(
    f"MCML_{name}"
    for name in (
        *(
            "BENCH_SCRUB",
            "DB_PASSWORD",
            "FUZZ_SEED",
            "GLB",
            "LIBRARIES",
            "LOAD_SECONDS",
            "LOAD_STORES",
            "SHARED",
            "TEST_LAG",
        ),
        *("SERVER", "THUMBNAILS"),
    )
)
"""Variables that are no settings: `docker-compose.yml`, tests and measurements read them."""


def unknown_variables(names: Iterable[str]) -> list[str]:
    """Return a message for each environment variable that looks like a setting but is none."""
    known = [f"MCML_{name.upper()}" for name in Settings.model_fields]
    told = []
    for name in sorted(names):
        upper = name.upper()
        if upper.startswith("MCML_") and upper not in known and upper not in OTHERS:
            near = get_close_matches(upper, known, 1)
            hint = f"Did you mean {near[0]}?" if near else "See docs/settings.md."
            told.append(f"{name} is no setting. {hint}")
    return told


class Settings(BaseSettings):
    """Every setting: environment variable `MCML_` and the name in capitals."""

    model_config = SettingsConfigDict(env_prefix="MCML_", extra="ignore")

    database: str | None = Field(None, description="SQLAlchemy URL; default: an SQLite file in the user's data folder")
    database_read_url: str | None = Field(
        None, description="SQLAlchemy URL of a streaming replica of a PostgreSQL store, for reading requests"
    )
    host: str = Field("127.0.0.1", description="Address to listen on; addresses other than loopback require a token")
    login: Literal["auto", "always"] = Field(
        "auto",
        description="always: every request needs a token; auto: but those on this machine to a fresh SQLite store",
    )
    openid_issuer: str | None = Field(
        None, description="URL of an OpenID Connect provider for signing in (needs the extra `openid`)"
    )
    openid_client_id: str = Field("mcml", description="Client id of this repository at the provider")
    openid_client_secret: str | None = Field(None, description="Client secret, if the provider issued one")
    openid_name: str = Field("OpenID Connect", description="Name of the provider on the sign-in button")
    openid_role: Literal["none", "member", "reader", "editor"] = Field(
        "none", description="Role for a first sign-in without an invitation; none: refused"
    )
    trusted_proxies: str = Field(
        "",
        description="Trusted proxies: addresses or networks, separated by commas, whose X-Forwarded- headers are used",
    )
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on")
    token: str | None = Field(None, description="Token that the command line sends to a server (`--server`)")
    max_upload_bytes: int = Field(2048 * MIB, ge=1, description="Maximum size of an upload, all files together")
    max_zip_ratio: float = Field(200.0, ge=1, description="Maximum compression ratio of a zip")
    max_zip_files: int = Field(2000, ge=1, description="Maximum number of files in a zip")
    max_frames: int = Field(50_000_000, ge=1, description="Maximum number of frames in a document")
    max_values: int = Field(4_000_000_000, ge=1, description="Maximum number of samples in a document")
    max_joints: int = Field(10_000, ge=1, description="Maximum number of joints in a skeleton")
    import_processes: int = Field(0, ge=0, description="Processes for importing short clips; 0: one per core, 1: off")
    derive: bool = Field(
        True, description="Whether a server derives bodies and builds columns of queries, and imports derive bodies"
    )
    read_seconds: float = Field(60.0, gt=0, description="Half of the time limit for reading music")
    read_memory_mib: int = Field(2048, ge=256, description="Memory limit for reading music")
    query_seconds: float = Field(10.0, gt=0, description="Time limit of an XPath query")
    query_memory_mib: int = Field(512, ge=64, description="Memory limit of an XPath query")
    query_cache_mib: int = Field(
        512, ge=8, description="Memory for columns that each process caches between XPath queries"
    )
    cache_dir: str = Field(
        "",
        description="Folder of the query cache; default: beside an SQLite store, else the user's cache; none: off",
    )
    cache_disk_mib: int = Field(4096, ge=1, description="Maximum size of the query cache on disk")
    query_elements: int = Field(3_000_000, ge=1000, description="Maximum number of elements in a query without columns")
    job_workers: int = Field(0, ge=0, description="Jobs that run at the same time; 0: all cores but one, at most 4")
    job_memory_mib: int = Field(4096, ge=256, description="Memory limit of a job")
    job_clips: int = Field(2000, ge=1, description="Maximum number of clips in an analysis")
    dask_scheduler: str | None = Field(
        None, description="Address of a Dask scheduler for jobs; needs PostgreSQL and the extra `cluster`"
    )
    dask_tls_ca: str | None = Field(None, description="CA certificate of the cluster of a tls:// scheduler")
    dask_tls_cert: str | None = Field(None, description="Certificate of this server in the cluster")
    dask_tls_key: str | None = Field(None, description="Private key of this server in the cluster")
    jobs_of_project: int = Field(
        0, ge=0, description="Jobs of one project that run at the same time, on all servers; 0: no limit"
    )
    cors_origins: str = Field("", description="Allowed CORS origins, separated by commas, such as https://lab.example")
    heavy_places: int = Field(
        0,
        ge=0,
        description="Heavy requests processed at the same time, for reads and for writes each; 0: number of cores",
    )
    heavy_waiting: int = Field(100, ge=1, description="Maximum number of waiting heavy requests of each kind")
    heavy_wait_seconds: float = Field(30.0, gt=0, description="Maximum waiting time of a heavy request")
    connections: int = Field(
        1000, ge=1, description="Maximum number of connections; at most half of the open-file limit"
    )
    header_seconds: float = Field(10.0, gt=0, description="Time limit for the headers of a request")
    stall_seconds: float = Field(30.0, gt=0, description="Time limit for a stalled request or response body")
    stop_seconds: int = Field(10, ge=1, description="Time for requests to finish when the server stops")
    log_format: Literal["text", "json"] = Field("text", description="Log format of a server")
    log_level: Literal["info", "warning", "error"] = Field("warning", description="info: also one line per request")
    activity_days: int = Field(
        400, ge=1, description="Days of activity to keep; a starting server deletes older entries"
    )
    webhook_private: bool = Field(False, description="Allow webhooks in private networks and without https")
    page_limit: int = Field(1000, ge=1, description="Maximum number of items per page")

    @field_validator("trusted_proxies")
    @classmethod
    def _networks(cls, text: str) -> str:
        _networks_in(text)
        return text

    @field_validator("openid_issuer")
    @classmethod
    def _issuer(cls, text: str | None) -> str | None:
        if text is None:
            return None
        address = urlsplit(text)
        if address.scheme != "https" and not is_loopback(address.hostname or ""):
            raise ValueError("a provider of sign-ins has an https address")
        if find_spec("authlib") is None:
            raise ValueError("signing in needs the extra openid: pip install 'mcml-repository[openid]'")
        return text

    @property
    def file_limits(self) -> FileLimits:
        """Limits for reading files."""
        return FileLimits(
            size=self.max_upload_bytes,
            archive_files=self.max_zip_files,
            archive_ratio=self.max_zip_ratio,
            frames=self.max_frames,
            values=self.max_values,
            joints=self.max_joints,
        )

    @property
    def proxies(self) -> list[ipaddress.IPv4Network | ipaddress.IPv6Network]:
        return _networks_in(self.trusted_proxies)

    @property
    def openid(self) -> str | None:
        """The provider's name for people, None without a provider."""
        return None if self.openid_issuer is None else self.openid_name

    @property
    def friends(self) -> list[str]:
        """Origins whose pages may use this server."""
        return [part.strip().rstrip("/") for part in self.cors_origins.split(",") if part.strip()]

    @property
    def knows_host(self) -> bool:
        """Whether the listening address is set. An application run by another program cannot see it."""
        return "host" in self.model_fields_set

    @property
    def jobs_at_a_time(self) -> int:
        return self.job_workers or max(1, min(4, (os.cpu_count() or 1) - 1))

    @property
    def heavy_at_once(self) -> int:
        return self.heavy_places or max(2, os.cpu_count() or 1)

    @property
    def import_processes_at_a_time(self) -> int:
        return self.import_processes or os.cpu_count() or 1

    @property
    def database_url(self) -> str:
        return self.database or f"sqlite:///{data_folder() / 'mcml.db'}"
