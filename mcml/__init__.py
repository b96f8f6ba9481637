"""Motion capture in Python: repositories on this machine or on a server, and files without any.

>>> import mcml
>>> with mcml.open("library.db") as repo:
...     walk = repo.import_("walk.bvh", label=["walk:1-20"]).documents[0]
...     print(walk.name, len(walk), walk.frames("Root").shape)
walk 240 (240, 6)

`open` opens a repository, `read` reads a motion from files, `convert` converts files to another format. Errors are of
type `Error` and have the problem, the place and the remedy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mcml.client.queries import Query, Run
    from mcml.client.repository import Document, Imported, Repository, open  # noqa: A004  # the name that is wanted
    from mcml.errors import McmlError as Error
    from mcml.files.motion import Motion, convert, read
    from mcml.frames import Frames

_HOMES = {
    "mcml.frames": ("Frames",),
    "mcml.files.motion": ("Motion", "convert", "read"),
    "mcml.client.queries": ("Query", "Run"),
    "mcml.client.repository": ("Document", "Imported", "Repository", "open"),
}

__all__ = ["Document", "Error", "Frames", "Imported", "Motion", "Query", "Repository", "Run", "convert", "open", "read"]


def __getattr__(name: str) -> Any:
    """Names are imported when they are used: the command line needs few of them, and mathematics takes a while."""
    if name == "Error":
        from mcml.errors import McmlError

        return McmlError
    for module, names in _HOMES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'mcml' has no attribute {name!r}")
