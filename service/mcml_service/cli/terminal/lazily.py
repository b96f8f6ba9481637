"""Commands that are created on use: imports of other commands are avoided, because mathematics takes a second to
import.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup


def lazy_command(make: Callable[[], tuple[Callable[..., None], str | None]]) -> type[TyperCommand]:
    """A class of commands. make: (what a command does, its help; None: the docstring)."""

    class Lazy(TyperCommand):
        _made: Any = None

        def _ready(self) -> Any:
            if self._made is None:
                function, words = make()
                alone = typer.Typer(add_completion=False)
                alone.command(help=words)(function)
                self._made = typer.main.get_command(alone)
            return self._made

        # Click sets these when it makes a command; these commands are made later.
        params = property(lambda self: self._ready().params, lambda self, _: None)
        callback = property(lambda self: self._ready().callback, lambda self, _: None)
        help = property(lambda self: self._ready().help, lambda self, _: None)

    return Lazy


def lazy_group(module: str) -> type[TyperGroup]:
    """Return a class of groups with the commands that `add_to` of a module adds."""

    class Lazy(TyperGroup):
        @property
        def commands(self) -> Any:
            if not hasattr(self, "_found"):
                group = typer.Typer()
                importlib.import_module(module).add_to(group)
                group_command: Any = typer.main.get_group(group)
                self._found = group_command.commands
            return self._found

        @commands.setter
        def commands(self, given: Any) -> None:
            """Click gives an empty group its commands."""

    return Lazy


def from_module(address: str) -> Callable[[], tuple[Callable[..., None], None]]:
    """Return the factory of a command from a function: `module:function` of this package."""

    def make() -> tuple[Callable[..., None], None]:
        module, _, name = address.partition(":")
        return getattr(importlib.import_module(f"mcml_service.cli.{module}"), name), None

    return make
