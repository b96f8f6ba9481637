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
    """What was imported is there; from now on garbage is collected, if it was before."""
    if _was_on:
        gc.enable()


def spare_what_stays() -> None:
    """For a program of its own: let what there is now, and at the end what there is then, never be looked through."""
    gc.freeze()
    gc.set_threshold(FEW)
    atexit.register(gc.freeze)
