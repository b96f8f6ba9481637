"""The secret by which commands enter a server of the same person on the same machine: a file that only they read."""

from __future__ import annotations

import os
import secrets
import tempfile
from pathlib import Path

from mcml_service.settings import private_folder

PREFIX = "mcml_local_"
NAME = "local-secret"


def read_secret(folder: Path) -> str | None:
    """The secret in a folder; None where there is none, or where others could have read it."""
    try:
        with (folder / NAME).open(encoding="ascii") as file:
            exposed = os.name == "posix" and os.fstat(file.fileno()).st_mode & 0o077
            text = file.read().strip()
    except (OSError, UnicodeDecodeError):
        return None
    return text if text.startswith(PREFIX) and not exposed else None


def keep_secret(folder: Path) -> str | None:
    """The secret in a folder, made where there is none; None where nothing can be written there."""
    secret = read_secret(folder)
    if secret is not None:
        return secret
    made = PREFIX + secrets.token_urlsafe(32)
    try:
        private_folder(folder)
        # Files of mkstemp have mode 0600 from the start, and replacing them is one step.
        descriptor, path = tempfile.mkstemp(prefix=NAME, dir=folder)
        with os.fdopen(descriptor, "w", encoding="ascii") as file:
            file.write(made)
        os.replace(path, folder / NAME)
    except OSError:
        return None
    return made
