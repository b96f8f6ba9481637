"""Where files that are not Python lie: beside the packages in a checkout, inside the package in a wheel."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


@cache
def dtd_path() -> Path:
    """The definition of the language, `mcml.dtd`."""
    return _find("mcml.dtd")


@cache
def migrations_path() -> Path:
    """The folder of database migrations."""
    return _find("migrations")


@cache
def joint_names_path() -> Path:
    """Table 1 as data."""
    return _PACKAGE / "mcml" / "joint_names.csv"


@cache
def motion_names_path() -> Path:
    """Parts of the body and the movements they can perform."""
    return _PACKAGE / "mcml" / "motion_names.csv"


@cache
def common_passwords_path() -> Path:
    """Passwords that nobody may have, a line each."""
    return _PACKAGE / "common_passwords.txt"


def _find(name: str) -> Path:
    # A wheel carries the files of the top level in service/_data, where pyproject.toml puts them.
    for candidate in (_PACKAGE.parent / name, _PACKAGE / "_data" / name):
        if candidate.exists():
            return candidate
    raise FileNotFoundError(f"{name} is missing from this installation; install the package again")


def program_version() -> str:
    """The version of the installed program, or 0+checkout where it is not installed."""
    try:
        return version("mcml-repository")
    except PackageNotFoundError:
        return "0+checkout"
