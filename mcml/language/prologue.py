"""The bytes of an uploaded document, made ready for the parser: UTF-8, and without the one allowed DOCTYPE.

A document may have `<!DOCTYPE mcml SYSTEM "mcml.dtd">` or no DOCTYPE. That line is blanked here; every DOCTYPE that the
parser still sees is refused, so that no entity can ever be declared and no file fetched.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from typing import BinaryIO

from mcml.errors import DocumentError, LimitError, Place
from mcml.patterns import end_of_matches

CHUNK = 1 << 16
PROLOGUE_LIMIT = 1 << 16
"""Bytes within which the root element must begin for its DOCTYPE to be recognised."""

_BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_DECLARED = re.compile(rb"""<\?xml\s[^>]*?encoding\s*=\s*["']([A-Za-z][A-Za-z0-9._-]*)["']""")
_READABLE = re.compile(
    r"utf-(8|16|32)(-[bl]e)?|ascii|iso8859-\d+|cp\d+|euc_\w+|shift_jis\w*|gb\w+|big5\w*|koi8-\w|johab"
)
_MISC = re.compile(rb"\s+|<!--.*?-->|<\?.*?\?>", re.DOTALL)
_DOCTYPE = re.compile(rb"<!DOCTYPE\s+mcml\s+SYSTEM\s+(?:\"mcml\.dtd\"|'mcml\.dtd')\s*>")
_ROOT = re.compile(rb"<[A-Za-z_:\x80-\xff]")


def utf8_chunks(stream: BinaryIO, max_bytes: int, encoding: str | None = None) -> Iterator[bytes]:
    """Yield the document from the stream's position on, as UTF-8 without BOM and without the allowed DOCTYPE.

    encoding: the encoding stated by the upload, for a document that does not state it. Lines stay where they are.
    Raises LimitError beyond max_bytes, DocumentError if the bytes are not in the stated encoding.
    """
    chunks = _limited(stream, max_bytes)
    head = b""
    for chunk in chunks:
        head += chunk
        if len(head) >= PROLOGUE_LIMIT or _ROOT.search(head):
            break
    name = encoding_of(head, encoding)
    if name == "utf-8":
        yield _without_doctype(head.removeprefix(codecs.BOM_UTF8))
        yield from chunks
        return
    decoder = codecs.getincrementaldecoder(name)("strict")
    try:
        yield _without_doctype(decoder.decode(head).encode())
        for chunk in chunks:
            yield decoder.decode(chunk).encode()
        yield decoder.decode(b"", True).encode()
    except UnicodeError:
        raise DocumentError(
            f"the document is not in {name}, which it says it is in", remedy="Save it as UTF-8."
        ) from None


def has_doctype(document: bytes) -> bool:
    """Whether a document, as `utf8_chunks` gives it, still has a DOCTYPE: one that is not allowed."""
    return document.startswith(b"<!DOCTYPE", end_of_matches(_MISC, document))


def refused_doctype(line: int | None, why: str) -> DocumentError:
    """The error for a DOCTYPE that is not the language's own."""
    return DocumentError(
        f"this DOCTYPE is refused: {why}",
        at=Place(line=line),
        remedy='Write <!DOCTYPE mcml SYSTEM "mcml.dtd">, or leave it out.',
    )


def encoding_of(head: bytes, encoding: str | None = None) -> str:
    """Return the codec of a document with this beginning: by BOM, its XML declaration, the upload, else UTF-8.

    Raises DocumentError for a name that is not a text encoding.
    """
    for mark, name in _BOMS:
        if head.startswith(mark):
            return name
    if head.startswith((b"<\x00", b"\x00<")):
        return "utf-16-le" if head[0] else "utf-16-be"
    declared = _DECLARED.match(head)
    stated = declared.group(1).decode() if declared else encoding or "utf-8"
    try:
        name = codecs.lookup(stated).name
    except LookupError:
        name = ""
    if not _READABLE.fullmatch(name) or name.startswith(("utf-16", "utf-32")):
        raise DocumentError(
            f"cannot read the encoding {stated!r}", at=Place(line=1), remedy="Save the document as UTF-8."
        )
    return name


def _limited(stream: BinaryIO, max_bytes: int) -> Iterator[bytes]:
    total = 0
    while chunk := stream.read(CHUNK):
        total += len(chunk)
        if total > max_bytes:
            raise LimitError(f"the document has more than {max_bytes} bytes", limit=max_bytes)
        yield chunk


def _without_doctype(head: bytes) -> bytes:
    found = _DOCTYPE.match(head, end_of_matches(_MISC, head))
    if not found:
        return head
    # Line feeds stay, so that the parser's line numbers are the document's.
    blank = re.sub(rb"[^\n]", b" ", found.group())
    return head[: found.start()] + blank + head[found.end() :]
