"""Passwords of accounts: Argon2 hashes, and what a password must be."""

from __future__ import annotations

from functools import cache
from threading import BoundedSemaphore

from pwdlib import PasswordHash
from pwdlib.exceptions import PwdlibError

from service.errors import RequestError
from service.resources import common_passwords_path

LEAST, MOST = 10, 256
"""Characters of a password. Nothing else is asked of it but that it is neither its owner's name nor one of those that
are tried first (NIST SP 800-63B)."""
MOST_OF_A_NAME = 64
_AT_ONCE = BoundedSemaphore(2)
"""A hash takes 64 MiB while it is made: many logins wait for each other, not for memory."""
TAKEN = ("local",)
"""Names of revisions that nobody signed."""


@cache
def _hasher() -> PasswordHash:
    return PasswordHash.recommended()


@cache
def _nobodys() -> str:
    """What passwords of names that are not there are compared with, so that they take as long."""
    return _hasher().hash("nobody has this password")


@cache
def _common() -> frozenset[str]:
    lines = common_passwords_path().read_text(encoding="utf-8").splitlines()
    return frozenset(line for line in lines if not line.startswith("# "))


def checked_name(name: str) -> str:
    """The name of a new account. RequestError."""
    name = name.strip()
    if not 0 < len(name) <= MOST_OF_A_NAME or not name.isprintable() or name in TAKEN:
        raise RequestError(
            "An account needs a name of its own.",
            remedy=f"Give one of up to {MOST_OF_A_NAME} characters, such as kim; not {', '.join(TAKEN)}.",
        )
    return name


def hashed(password: str, name: str) -> str:
    """The hash that is kept of a new password. RequestError where it is too short, the name, or common."""
    if not LEAST <= len(password) <= MOST or password.casefold() == name.casefold():
        raise RequestError(
            f"A password has {LEAST} to {MOST} characters, and is not the name.",
            remedy="A few words in a row are easy to keep in mind.",
        )
    if password.casefold() in _common():
        raise RequestError(
            "This password is one of the 5,000 that are tried first.",
            remedy="A few words in a row are easy to keep in mind.",
        )
    with _AT_ONCE:
        return _hasher().hash(password)


def opens(password: str, kept: str | None) -> bool:
    """Whether a password is the one whose hash is kept; it takes as long where none is."""
    try:
        with _AT_ONCE:
            right = _hasher().verify(password[: MOST + 1], kept or _nobodys())
    except PwdlibError:
        return False
    return right and kept is not None
