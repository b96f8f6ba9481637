"""Whole answers as bytes: XML, NDJSON, CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterator

import orjson

from schemas.queries import NodeItem
from service.mcml.writer import text_bytes
from service.xpath.nodes import Node
from service.xpath.streams import Answer, Shown

FIELDS = ("document", "revision", "kind", "address", "value")


def xml_item(item: NodeItem | Node) -> str:
    """A `result` with the place of a node and the node itself. Addresses hold nothing that XML would escape."""
    document, revision = (
        (item.document, item.revision) if isinstance(item, NodeItem) else (item.stored.uuid, item.stored.revision)
    )
    value = item.value if item.kind in ("element", "document") else text_bytes(item.value).decode()
    return f'<result document="{document}" revision="{revision}" address="{item.address}">{value}</result>\n'


def _xml(found: Answer | Shown) -> Iterator[bytes]:
    yield b'<?xml version="1.0" encoding="UTF-8"?>\n<results>\n'
    for nodes in found.nodes():
        yield "".join([xml_item(node) for node in nodes]).encode()
    yield b"</results>\n"


def _ndjson(found: Answer | Shown) -> Iterator[bytes]:
    """A JSON object a line, as the items of a page."""
    for nodes in found.nodes():
        yield b"".join([_line(node) for node in nodes])


def _line(node: Node) -> bytes:
    return orjson.dumps(dict(zip(FIELDS, _values(node), strict=True)), option=orjson.OPT_APPEND_NEWLINE)


def _csv(found: Answer | Shown) -> Iterator[bytes]:
    """A row a node, RFC 4180."""
    yield (",".join(FIELDS) + "\r\n").encode()
    for nodes in found.nodes():
        text = io.StringIO()
        csv.writer(text).writerows(_values(node) for node in nodes)
        yield text.getvalue().encode()


def _values(node: Node) -> tuple[str | int, ...]:
    return node.stored.uuid, node.stored.revision, node.kind, node.address, node.value


STREAMS: dict[str, tuple[Callable[[Answer | Shown], Iterator[bytes]], str]] = {
    "xml": (_xml, "application/xml"),
    "ndjson": (_ndjson, "application/x-ndjson"),
    "csv": (_csv, "text/csv"),
}
"""For each form, what writes it, and its media type."""
