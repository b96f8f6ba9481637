"""Python's collector of garbage, which a short command does without.

Importing makes hundreds of thousands of objects that all stay; to look through them for garbage again and again, and
once more at the end, takes a third of the time of `mcml ls`. It rests from the first import of this module on.
"""

from __future__ import annotations

import atexit
import gc

FEW = 20_000
"""Objects that are made before new ones are looked through."""

_was_on = gc.isenabled()
gc.disable()


def collect_again() -> None:
    """Enable garbage collection again after imports, if it was enabled before."""
    if _was_on:
        gc.enable()


def spare_what_stays() -> None:
    """Exclude existing objects from garbage collection, now and at exit. Only for a program that owns its process."""
    gc.freeze()
    gc.set_threshold(FEW)
    atexit.register(gc.freeze)
