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
    """The user's folder of what may be lost (XDG on Linux, the platform's own elsewhere)."""
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "mcml"
    if sys.platform == "win32":
        return data_folder() / "cache"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "mcml"


def private_folder(folder: Path) -> Path:
    """The folder, made where it is not there; the data folder is for its owner alone."""
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
    """What is wrong with variables of the environment that look like settings and are none, each in a sentence."""
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
        None, description="SQLAlchemy URL of a streaming replica of a PostgreSQL store, which answers what only reads"
    )
    host: str = Field("127.0.0.1", description="Address to listen on; any other than loopback needs a token")
    login: Literal["auto", "always"] = Field(
        "auto",
        description="always: every request needs a token; auto: but those on this machine to a fresh SQLite store",
    )
    openid_issuer: str | None = Field(
        None, description="Address of a provider of OpenID Connect with which people sign in (needs the extra `openid`)"
    )
    openid_client_id: str = Field("mcml", description="What the provider calls this repository")
    openid_client_secret: str | None = Field(None, description="The secret that the provider gave it, where it has one")
    openid_name: str = Field("OpenID Connect", description="What the button of the login page calls the provider")
    openid_role: Literal["none", "member", "reader", "editor"] = Field(
        "none", description="Role of who signs in for the first time without an invitation; none: nobody comes in so"
    )
    trusted_proxies: str = Field(
        "", description="Addresses or networks, separated by commas, of proxies whose X-Forwarded- headers count"
    )
    port: int = Field(8000, ge=0, le=65535, description="Port to listen on")
    token: str | None = Field(None, description="Token that the command line sends to a server (`--server`)")
    max_upload_bytes: int = Field(2048 * MIB, ge=1, description="Largest upload, all files of a request together")
    max_zip_ratio: float = Field(200.0, ge=1, description="A zip whose content is larger by more than this is refused")
    max_zip_files: int = Field(2000, ge=1, description="Most files in one zip")
    max_frames: int = Field(50_000_000, ge=1, description="Most frames in one document")
    max_values: int = Field(4_000_000_000, ge=1, description="Most motion values in one document")
    max_joints: int = Field(10_000, ge=1, description="Most joints in one skeleton")
    import_processes: int = Field(0, ge=0, description="Processes that read short clips; 0: one a core, 1: off")
    derive: bool = Field(
        True, description="Whether a server derives bodies and builds columns of queries, and imports derive bodies"
    )
    read_seconds: float = Field(60.0, gt=0, description="Half of the longest time that reading music may take")
    read_memory_mib: int = Field(2048, ge=256, description="Most memory that reading music may take")
    query_seconds: float = Field(10.0, gt=0, description="Longest time one XPath query may take")
    query_memory_mib: int = Field(512, ge=64, description="Most memory that one XPath query may take")
    query_cache_mib: int = Field(
        512, ge=8, description="Memory for columns that each process keeps between the XPath queries it evaluates"
    )
    cache_dir: str = Field(
        "",
        description="Folder of what queries keep on disk; default: beside an SQLite store, else the user's; none: off",
    )
    cache_disk_mib: int = Field(1024, ge=1, description="Most that queries keep on disk")
    query_elements: int = Field(3_000_000, ge=1000, description="Most elements that a projected query may touch")
    job_workers: int = Field(0, ge=0, description="Jobs that run at a time; 0: one for every core but one, at most 4")
    job_memory_mib: int = Field(4096, ge=256, description="Most memory one job may take")
    job_clips: int = Field(2000, ge=1, description="Most clips one analysis may read")
    dask_scheduler: str | None = Field(
        None, description="Address of a team's Dask scheduler to run jobs on; needs PostgreSQL and the extra cluster"
    )
    dask_tls_ca: str | None = Field(None, description="Certificate that signed those of a tls:// scheduler's cluster")
    dask_tls_cert: str | None = Field(None, description="Certificate of this server in that cluster")
    dask_tls_key: str | None = Field(None, description="Its key")
    jobs_of_project: int = Field(0, ge=0, description="Jobs of one project that run at a time, on all servers; 0: any")
    cors_origins: str = Field(
        "", description="Origins, separated by commas, whose pages may use this server, such as https://lab.example"
    )
    heavy_places: int = Field(
        0, ge=0, description="Heavy requests worked on at a time, of those that read and of those that write; 0: cores"
    )
    heavy_waiting: int = Field(100, ge=1, description="Most heavy requests that wait, of either kind")
    heavy_wait_seconds: float = Field(30.0, gt=0, description="Longest time that one waits")
    connections: int = Field(1000, ge=1, description="Most connections; never more than half of the open files")
    header_seconds: float = Field(10.0, gt=0, description="Longest time until the headers of a request are there")
    stall_seconds: float = Field(
        30.0, gt=0, description="Longest time in which a body brings, or a client takes, next to nothing"
    )
    stop_seconds: int = Field(10, ge=1, description="Time that requests have to end when the server stops")
    log_format: Literal["text", "json"] = Field("text", description="How a server writes its log")
    log_level: Literal["info", "warning", "error"] = Field("warning", description="info: a line for each request too")
    activity_days: int = Field(
        400, ge=1, description="Days that the list of what was done goes back; a server that starts forgets the rest"
    )
    webhook_private: bool = Field(False, description="Whether webhooks may be in private networks, and without https")
    page_limit: int = Field(1000, ge=1, description="Most items on one page of a list")

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
        """Bounds of what is read of files."""
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
        """The provider's name for people, None where there is none."""
        return None if self.openid_issuer is None else self.openid_name

    @property
    def friends(self) -> list[str]:
        """Origins whose pages may use this server."""
        return [part.strip().rstrip("/") for part in self.cors_origins.split(",") if part.strip()]

    @property
    def knows_host(self) -> bool:
        """Whether somebody said what is listened on. An application that another program serves cannot see it."""
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
