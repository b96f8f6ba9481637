"""Groups of commands whose modules are imported when one of them is wanted: mathematics takes a second to import."""

from __future__ import annotations

import importlib
from typing import Any

import typer
from typer.core import TyperGroup


def later(module: str) -> type[TyperGroup]:
    """A class of groups whose commands are those that `add_to` of a module adds."""

    class Later(TyperGroup):
        @property
        def commands(self) -> Any:
            if not hasattr(self, "_found"):
                group = typer.Typer()
                importlib.import_module(module).add_to(group)
                found: Any = typer.main.get_group(group)
                self._found = found.commands
            return self._found

        @commands.setter
        def commands(self, given: Any) -> None:
            """Click gives an empty group its commands; ours come later."""

    return Later
