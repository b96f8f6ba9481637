"""Documents made to harm: refused with a clear error, in little time and memory."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from io import BytesIO, RawIOBase

import pytest

from mcml.errors import DocumentError, LimitError
from mcml.language import dtd
from mcml.language.reader import Limits, read_document

pytestmark = pytest.mark.above_store

HEAD = b'<mcml version="1.0"><header/><skeleton><bone><name>a</name></bone></skeleton>'
BOMB = b'<?xml version="1.0"?><!DOCTYPE mcml [<!ENTITY a "aaaaaaaaaa">' + b"".join(
    b'<!ENTITY %c "%s">' % (97 + n, b"&%c;" % (96 + n) * 10) for n in range(1, 12)
)


def read(document: bytes, **limits: int) -> None:
    for _ in read_document(BytesIO(document), Limits(**limits)).clip.blocks():
        pass


DOCTYPES = {
    "entity bomb in text": BOMB + b"]><mcml>&l;</mcml>",
    "entity bomb in an attribute": BOMB + b"]><mcml version='&l;'/>",
    "quadratic bomb": b"<!DOCTYPE mcml [<!ENTITY a '" + b"a" * 50000 + b"'>]><mcml>" + b"&a;" * 5000 + b"</mcml>",
    "external entity": b'<!DOCTYPE mcml [<!ENTITY x SYSTEM "file:///etc/passwd">]><mcml version="&x;"/>',
    "parameter entity": b'<!DOCTYPE mcml [<!ENTITY % x SYSTEM "http://127.0.0.1:9/x"> %x;]><mcml/>',
    "own declarations": b'<!DOCTYPE mcml SYSTEM "mcml.dtd" [<!ELEMENT mcml ANY>]><mcml/>',
    "another DTD": b'<!DOCTYPE mcml SYSTEM "http://127.0.0.1:9/mcml.dtd"><mcml version="1.0"/>',
    "a file's DTD": b'<!DOCTYPE mcml SYSTEM "file:///etc/passwd"><mcml version="1.0"/>',
    "a public DTD": b'<!DOCTYPE mcml PUBLIC "-//X//Y" "mcml.dtd"><mcml version="1.0"/>',
    "another root": b'<!DOCTYPE html SYSTEM "mcml.dtd"><mcml version="1.0"/>',
    "after long comments": b"<!--" + b"x" * 70000 + b'--><!DOCTYPE mcml [<!ENTITY a "b">]><mcml/>',
}


@pytest.mark.parametrize("name", DOCTYPES)
def test_every_other_doctype_is_refused(name: str) -> None:
    for check in (read, dtd.validate):
        with pytest.raises(DocumentError, match="DOCTYPE is refused"):
            check(DOCTYPES[name])


@pytest.mark.parametrize("doctype", ['<!DOCTYPE mcml SYSTEM "mcml.dtd">', "<!DOCTYPE  mcml\nSYSTEM 'mcml.dtd' >", ""])
def test_the_one_doctype_or_none_is_accepted(doctype: str) -> None:
    read(doctype.encode() + HEAD + b"<motion><frames>0</frames></motion></mcml>")


@pytest.mark.parametrize("place", [b'<mcml version="&x;">', b"<mcml version='1.0'><header>&x;</header>"])
@pytest.mark.parametrize("doctype", [b"", b'<!DOCTYPE mcml SYSTEM "mcml.dtd">'])
def test_undeclared_entities_are_refused(doctype: bytes, place: bytes) -> None:
    with pytest.raises(DocumentError, match="undefined entity"):
        read(doctype + place)


@pytest.mark.parametrize(
    "spaces", [b" " * 200_000, b"<!-- -->" * 20_000, b"\n<?a b?>" * 20_000, b"<!--" * 50_000, b"<?" * 50_000]
)
@pytest.mark.timeout(30)
def test_long_prologues_are_read_once(spaces: bytes) -> None:
    """An expression that tried every beginning would take hours."""
    with pytest.raises((DocumentError, LimitError)):
        read(spaces + b"<x/>")
    with pytest.raises(DocumentError):
        dtd.validate(spaces + b"<x/>")


def test_deep_nesting_is_refused() -> None:
    with pytest.raises(LimitError, match="nested deeper"):
        read(b'<mcml version="1.0"><header/><skeleton>' + b"<bone><name>a</name>" * 100_000)
    with pytest.raises(DocumentError):
        dtd.validate(b"<bone>" * 100_000)


def test_other_limits() -> None:
    frame = HEAD + b'<motion><frames>1</frames><frame id="1">'
    header = b'<mcml version="1.0"><header>'
    cases: list[tuple[bytes, dict[str, int], str]] = [
        (b'<mcml version="' + b"1" * 500_000 + b'"/>', {"max_text": 1000}, "a tag or text has more than 1000"),
        (header + b"<filename>" + b"a" * 300_000, {"max_text": 1000}, "a text has more than 1000"),
        (HEAD, {"max_bytes": 20}, "more than 20 bytes"),
        (header + b"<comment>abc</comment>" * 99, {"max_head": 500}, "more than 500 characters"),
        (frame.replace(b">1<", b">9999999<"), {"max_frames": 10}, "more than 10 frames"),
        (HEAD + b"<motion><frames>3</frames>" + b'<frame id="1"/>' * 5, {"max_frames": 3}, "more than 3 frames"),
        (frame + b"<motion_name>x</motion_name>" * 5, {"max_names": 4}, "more than 4 motion names"),
    ]
    for document, limits, message in cases:
        with pytest.raises(LimitError, match=message):
            read(document, **limits)


class Endless(RawIOBase):
    """A document that never ends, as a network could send it."""

    def __init__(self, head: bytes, rest: bytes) -> None:
        self._parts = self._generate(head, rest)

    def _generate(self, head: bytes, rest: bytes) -> Iterator[bytes]:
        yield head
        while True:
            yield rest

    def readable(self) -> bool:
        return True

    def read(self, size: int = -1) -> bytes:
        return next(self._parts)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("head", "rest"),
    [
        (HEAD + b"<motion><frames>9000000</frames>", b'<frame id="1"><frame_bone name="a" Tx="1"/></frame>' * 1000),
        (HEAD + b'<motion><frames>1</frames><frame id="1">', b'<frame_bone name="a" Tx="1"/>' * 1000),
        (HEAD + b'<motion><frames>1</frames><frame id="1">', b"<motion_name>x</motion_name>" * 1000),
        (HEAD + b'<motion><frames>1</frames><frame id="', b"1" * 50_000),
        (HEAD + b"<motion><frames>1</frames>", b" " * 50_000),
        (HEAD + b"<motion><frames>1</frames>", b"<!-- x -->" * 5_000),
        (HEAD + b"<!--", b"x" * 50_000),
        (b'<mcml version="1.0"><header>', b"<comment/>" * 5000),
    ],
)
def test_endless_documents_take_bounded_memory(head: bytes, rest: bytes) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    with pytest.raises((LimitError, DocumentError)):
        for _ in read_document(Endless(head, rest), Limits(max_bytes=12_000_000)).clip.blocks():
            pass
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 120_000


@pytest.mark.parametrize(
    "junk", [b"", b"\x00" * 100, b"PK\x03\x04", b"\xff\xfe", b"<", b"{}", "걷기".encode(), b"<mcml", b"\xef\xbb\xbf"]
)
def test_junk_is_refused(junk: bytes) -> None:
    for check in (read, dtd.validate):
        with pytest.raises(DocumentError):
            check(junk)


@pytest.mark.parametrize("name", ["utf-7", "rot13", "hex", "unicode_escape", "idna", "no-such", "utf-16", "punycode"])
def test_only_encodings_of_text_are_read(name: str) -> None:
    with pytest.raises(DocumentError, match="cannot read the encoding"):
        read(f'<?xml version="1.0" encoding="{name}"?><mcml/>'.encode())


def test_bytes_that_are_not_in_the_encoding() -> None:
    with pytest.raises(DocumentError, match="not well-formed"):
        read(b'<mcml version="\xff"/>')
    with pytest.raises(DocumentError, match="not in euc_kr"):
        read(b'<?xml version="1.0" encoding="euc-kr"?><mcml version="\xff"/>')


def test_a_document_cut_anywhere_is_refused() -> None:
    whole = HEAD + b'<motion><frames>1</frames><frame id="1"><frame_bone name="a" Tx="1"/></frame></motion></mcml>'
    read(whole)
    for cut in range(len(whole)):
        with pytest.raises(DocumentError):
            read(whole[:cut])
