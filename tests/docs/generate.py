"""Tables in docs/ that come from catalogues. `python -m tests.docs.generate` writes them; a test compares."""

from __future__ import annotations

import re
from pathlib import Path

import typer
from typer.main import get_command

from mcml.language import joint_names, motion_names
from mcml_service.cli import app as cli
from mcml_service.operations import all_operations
from mcml_service.operations.operation import RIGHTS, Right
from mcml_service.storage.team.entries import PROJECT_ROLES, ROLES
from tests.builders import description

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGES = [*sorted(DOCS.rglob("*.md")), DOCS.parent / "README.md", DOCS.parent / "SECURITY.md"]
BY_HAND = {
    "follow_job": "read",
    **dict.fromkeys(("healthz", "readyz", "open_session", "close_session", "open_shared"), "none"),
}
BY_HAND |= dict.fromkeys(("metrics", "follow_events"), "read")
"""Rights of endpoints that are no operation."""

MARK = re.compile(r"(<!-- generated: (?P<name>[a-z-]+) -->\n).*?(<!-- end -->)", re.DOTALL)


def endpoints() -> str:
    schema = description()
    known = {operation.name: operation for operation in all_operations()}
    lines = ["| endpoint | operation | to the store | right | what it does |", "|---|---|---|---|---|"]
    for path, methods in sorted(schema["paths"].items()):
        for method, operation in methods.items():
            what = operation.get("description", operation.get("summary", "")).split("\n")[0]
            name = operation["operationId"]
            # What is made by hand is about jobs that one may see, health, and the session itself.
            does, needs = (known[name].effect, known[name].right) if name in known else ("reads", BY_HAND[name])
            lines.append(f"| `{method.upper()} {path}` | `{name}` | {does} | {needs} | {what} |")
    return "\n".join(lines) + "\n"


def commands() -> str:
    lines = ["| command | what it does | options |", "|---|---|---|"]

    def add(command: object, name: str) -> None:
        children = getattr(command, "commands", None)
        if children:
            for child, inner in children.items():
                add(inner, f"{name} {child}")
            return
        options = [
            f"`{max(parameter.opts, key=len)}`"
            for parameter in command.params  # type: ignore[attr-defined]
            if parameter.param_type_name == "option" and "--help" not in parameter.opts
        ]
        arguments = " ".join(
            parameter.name.upper()
            for parameter in command.params  # type: ignore[attr-defined]
            if parameter.param_type_name == "argument"
        )
        what = (command.help or "").split("\n")[0]  # type: ignore[attr-defined]
        lines.append(f"| `{f'{name} {arguments}'.strip()}` | {what} | {' '.join(options)} |")

    add(get_command(cli), "mcml")
    return "\n".join(lines) + "\n"


def joints() -> str:
    heads = ("asf", "asf_alias", "bvh1", "bvh2", "htr")
    lines = ["| # | MCML | ASF/AMC | alias | BVH (1) | BVH (2) | HTR | |", "|---|---|---|---|---|---|---|---|"]
    for row in joint_names.table():
        cells = " | ".join((row.columns.get(head) or "").replace("|", ", ") for head in heads)
        lines.append(f"| {row.number} | {row.name} | {cells} | {'reconstructed' if row.reconstructed else ''} |")
    return "\n".join(lines) + "\n"


def movements() -> str:
    lines = ["| part | side | joints | movements |", "|---|---|---|---|"]
    for part in motion_names.parts().values():
        lines.append(
            f"| {part.name} | {'needed' if part.sided else 'none'} | {', '.join(part.joints)} "
            f"| {', '.join(part.movements)} |"
        )
    return "\n".join(lines) + "\n"


def rights() -> str:
    """Who has which right, and where."""
    wheres = ("every project", "that project")
    lines = ["| who | " + " | ".join(Right) + " |", "|---" * (1 + len(Right)) + "|"]
    for roles, of, where in zip((ROLES, PROJECT_ROLES), ("the repository", "a project"), wheres, strict=True):
        for role, scope in roles.items():
            held = RIGHTS[scope] if scope else frozenset()
            cells = ["the whole store" if right is Right.OPERATE else where for right in Right]
            shown = [cell if right in held else "–" for cell, right in zip(cells, Right, strict=True)]
            lines.append(f"| {role} of {of} | {' | '.join(shown)} |")
    return "\n".join(lines) + "\n"


TABLES = {"rights": rights, "endpoints": endpoints, "commands": commands, "joint-names": joints, "movements": movements}


def renewed(text: str) -> str:
    """A page with its generated tables made again."""
    return MARK.sub(lambda match: match[1] + TABLES[match["name"]]() + match[3], text)


def main() -> None:
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        fresh = renewed(text)
        if fresh != text:
            page.write_text(fresh, encoding="utf-8")
            typer.echo(f"wrote {page.relative_to(DOCS.parent)}")


if __name__ == "__main__":
    main()
