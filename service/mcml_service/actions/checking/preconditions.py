"""If-Match: check that a change was made for the current revision."""

from __future__ import annotations

from mcml_service.actions.checking.describe_problem import PreconditionError


def check_match(if_match: str | None, current: int, what: str, number: str) -> None:
    """PreconditionError unless a request was made for the current revision or version.

    if_match: the header: tags `"7"` or `"7-json"`, one of which has to name the current number, or `*`. A weak tag,
    `W/…`, never does: the comparison is strong (RFC 9110, 13.1.1). what: "document" or so. number: "revision" or so.
    """
    if if_match is None:
        raise PreconditionError(
            f"This request changes a {what} and must say which {number} it was made for.",
            428,
            f'Send the header If-Match: "{current}", or If-Match: * to change the current revision.',
        )
    tags = [tag.strip() for tag in if_match.split(",")]
    strong = {tag.strip('"').split("-")[0] for tag in tags if not tag.startswith("W/")}
    if strong & {"*", str(current)}:
        return
    if not strong:
        raise PreconditionError(
            f"If-Match compares strongly, and {if_match.strip()} is a weak tag.",
            412,
            f'Send the tag as it was answered, or the {number} alone: "{current}".',
        )
    raise PreconditionError(
        f"The {what} is at {number} {current}, the request was made for another one.",
        412,
        f"Read the {what} again and repeat the change.",
    )
