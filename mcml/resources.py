"""Places of files that are not Python: beside the package in a checkout, inside it in a wheel."""

from __future__ import annotations

from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


@cache
def dtd_path() -> Path:
    """The definition of the language, `mcml.dtd`."""
    return find_resource(_PACKAGE, "mcml.dtd")


@cache
def joint_names_path() -> Path:
    """Table 1 as data."""
    return _PACKAGE / "language" / "joint_names.csv"


@cache
def rig_words_path() -> Path:
    """Words that names of joints are made of, in several languages."""
    return _PACKAGE / "motion" / "rigs" / "words.csv"


@cache
def landmark_sets_path() -> Path:
    """Sets of markers and the landmark of each marker."""
    return _PACKAGE / "motion" / "landmarks" / "sets.csv"


@cache
def landmark_words_path() -> Path:
    """Words of markers and their landmarks."""
    return _PACKAGE / "motion" / "landmarks" / "words.csv"


@cache
def known_rigs_path() -> Path:
    """Joints of known rigs."""
    return _PACKAGE / "motion" / "retargeting" / "known_rigs.csv"


@cache
def body_places_path() -> Path:
    """Places of the body in whose measures known rigs are made."""
    return _PACKAGE / "motion" / "retargeting" / "body_places.csv"


@cache
def motion_names_path() -> Path:
    """Parts of the body and the movements they can perform."""
    return _PACKAGE / "language" / "motion_names.csv"


def find_resource(package: Path, name: str) -> Path:
    """Return a file that is in `_data` of a package in a wheel, and beside the package or above it in a checkout.

    Raises FileNotFoundError.
    """
    for candidate in (package / "_data" / name, package.parent / name, package.parent.parent / name):
        if candidate.exists():
            return candidate
    raise FileNotFoundError(f"{name} is missing from this installation; install the package again")


def program_version() -> str:
    """The version of the installed program, or 0+checkout where it is not installed."""
    try:
        return version("mcml-repository")
    except PackageNotFoundError:
        return "0+checkout"
