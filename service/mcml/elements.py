"""Elements of the head of a document (everything but its frames), and what they say of a clip.

`from_head` and `to_head` are inverse: a clip's head as elements of `mcml.dtd`, and back.
"""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(slots=True)
class Element:
    """One element: tag, attributes in order, text (only of leaves), children."""

    tag: str
    attributes: dict[str, str] = field(default_factory=dict)
    text: str = ""
    children: list[Element] = field(default_factory=list)
