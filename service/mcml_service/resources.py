"""Where files of the service that are not Python lie; see `mcml.resources`."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from mcml.resources import find_resource

_PACKAGE = Path(__file__).resolve().parent


@cache
def migrations_path() -> Path:
    """The folder of database migrations."""
    return find_resource(_PACKAGE, "migrations")


@cache
def common_passwords_path() -> Path:
    """Passwords that nobody may have, a line each."""
    return _PACKAGE / "common_passwords.txt"


@cache
def login_words_path() -> Path:
    """Sentences of the sign-in pages in the languages beside English: language, English sentence, translation."""
    return _PACKAGE / "login_words.json"


@cache
def studio_path() -> Path:
    """The folder of the studio: `static`, which is served, once it is built, and pages.json."""
    return find_resource(_PACKAGE, "web")
