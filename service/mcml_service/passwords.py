"""Passwords of accounts: Argon2 hashes, and rules for passwords."""

from __future__ import annotations

import re
from functools import cache
from threading import BoundedSemaphore

from pwdlib import PasswordHash
from pwdlib.exceptions import PwdlibError

from mcml.errors import RequestError
from mcml_service.resources import common_passwords_path

LEAST, MOST = 10, 256
"""Limits of a password's length.

The only other rule excludes passwords that attackers try first: common ones, the owner's name, repetitions, and
keyboard rows (NIST SP 800-63B, 5.1.1.2).
"""
LEAST_OWN = 7
"""Characters, spaces aside, that are left of a password without its owner's name, repetitions and keys in a row."""
_ROWS = (
    *("1234567890", "abcdefghijklmnopqrstuvwxyz", "qwertyuiop", "qwertzuiop", "azertyuiop", "asdfghjkl", "zxcvbnm"),
    "1qaz2wsx3edc4rfv5tgb6yhn7ujm8ik",
)
_ROW = 4
"""Number of adjacent keys that form a row; shorter rows occur in words, such as rty in party."""
_NAME = 3
"""Shorter names are in words."""
MOST_OF_A_NAME = 64
_AT_ONCE = BoundedSemaphore(2)
"""A hash takes 64 MiB while it is made: many logins wait for each other, not for memory."""
TAKEN = ("local",)
"""Reserved names of revisions without an author."""


@cache
def _hasher() -> PasswordHash:
    return PasswordHash.recommended()


@cache
def _nobodys() -> str:
    """Return the hash for comparing passwords of unknown names, so that they take as long."""
    return _hasher().hash("nobody has this password")


@cache
def _common() -> frozenset[str]:
    lines = common_passwords_path().read_text(encoding="utf-8").splitlines()
    return frozenset(line for line in lines if not line.startswith("# "))


def check_name(name: str) -> str:
    """The name of a new account. RequestError."""
    name = name.strip()
    if not 0 < len(name) <= MOST_OF_A_NAME or not name.isprintable() or name in TAKEN:
        raise RequestError(
            "An account needs a name of its own.",
            remedy=f"Give one of up to {MOST_OF_A_NAME} characters, such as kim; not {', '.join(TAKEN)}.",
        )
    return name


def hash_password(password: str, name: str) -> str:
    """The hash that is kept of a new password. RequestError where it is too short, easy to guess, or common."""
    if not LEAST <= len(password) <= MOST:
        raise RequestError(
            f"A password has {LEAST} to {MOST} characters.", remedy="A few words in a row are easy to keep in mind."
        )
    if password.casefold() in _common():
        raise RequestError(
            "This password is one of the 5,000 that are tried first.",
            remedy="A few words in a row are easy to keep in mind.",
        )
    if len(own_characters(password, name)) < LEAST_OWN:
        raise RequestError(
            "This password is easy to guess: the account's name, repetitions and keys in a row do not count.",
            remedy="A few different words in a row are easy to keep in mind.",
        )
    with _AT_ONCE:
        return _hasher().hash(password)


def own_characters(password: str, name: str) -> str:
    """Return a password without spaces, its owner's name, keyboard rows and repetitions; empty if it repeats fewer
    than LEAST characters.
    """
    text = "".join(password.casefold().split())
    words = ["".join(name.casefold().split()), *name.casefold().split()]
    for word in words:
        if len(word) >= _NAME:
            text = text.replace(word, "").replace(word[::-1], "")
    letters = re.sub(r"[\W_]", "", text) or text
    if (repeated := re.fullmatch(r"(.+?)\1+", letters)) and len(repeated[1]) < LEAST:
        return ""
    # Each by its first time: aa, then abab.
    return re.sub(r"(.{2,}?)\1+", r"\1", _without_rows(re.sub(r"(.)\1+", r"\1", text)))


def _without_rows(text: str) -> str:
    """The text with each row of keys, in either direction, as its first one."""
    kept, place = "", 0
    while place < len(text):
        end = max(_row_end(text, place, row) for keys in _ROWS for row in (keys, keys[::-1]))
        kept += text[place]
        place = end if end - place >= _ROW else place + 1
    return kept


def _row_end(text: str, place: int, row: str) -> int:
    """Behind the last character from `place` on that follows the one before it in a row."""
    end = place + 1
    while end < len(text) and text[end - 1 : end + 1] in row:
        end += 1
    return end


def opens(password: str, kept: str | None) -> bool:
    """Whether a password is the one whose hash is kept; it takes as long where none is."""
    try:
        with _AT_ONCE:
            right = _hasher().verify(password[: MOST + 1], kept or _nobodys())
    except PwdlibError:
        return False
    return right and kept is not None
