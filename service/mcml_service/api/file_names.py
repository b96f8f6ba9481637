"""The names of uploaded files as senders write them: `filename*` alone, UTF-8, or the encoding of their system."""

from __future__ import annotations

import re
from urllib.parse import unquote_to_bytes

import starlette.requests
from python_multipart.multipart import parse_options_header
from starlette.formparsers import MultiPartParser

from mcml.formats.text.plausible_text import plausible_codecs

_EXTENDED = re.compile(rb";\s*filename\*\s*=\s*\"?([A-Za-z0-9._-]*)'[^']*'([^;\"\s]*)", re.IGNORECASE)


class NamedFilesParser(MultiPartParser):
    """A parser of forms that finds the names of files which the library passes over.

    RFC 7578 has no `filename*` in forms, and so it is ignored, and its part is a text; yet clients send it.
    """

    def on_headers_finished(self) -> None:
        part = self._current_part
        name = file_name_in(part.content_disposition or b"")
        if name is not None and part.content_disposition is not None:
            quoted = name.encode().replace(b"\\", b"\\\\").replace(b'"', b'\\"')
            part.content_disposition += b'; filename="' + quoted + b'"'
        super().on_headers_finished()


def file_name_in(disposition: bytes) -> str | None:
    """The name that a Content-Disposition means, where the library would read another or none."""
    plain = parse_options_header(disposition)[1].get(b"filename")
    if plain is not None:
        try:
            plain.decode()
        except UnicodeDecodeError:
            codecs = plausible_codecs(plain, "latin-1")
            return plain.decode(codecs[0] if codecs else "latin-1")
        return None
    match = _EXTENDED.search(disposition)
    if match is None:
        return None
    try:
        return unquote_to_bytes(match[2]).decode(match[1].decode("ascii") or "utf-8")
    except (LookupError, UnicodeDecodeError):
        return unquote_to_bytes(match[2]).decode("utf-8", errors="replace")


def read_names_in_forms() -> None:
    """Make requests of this process parse forms this way; the library has no other hook for the parser."""
    starlette.requests.MultiPartParser = NamedFilesParser  # type: ignore[attr-defined]
