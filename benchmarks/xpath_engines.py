"""Four engines, asked the same: our server over HTTP, BaseX (`basex_client` says how), lxml, PostgreSQL's xpath().

Each gives its whole answer as its user reads it; `same` makes of it what can be compared.
"""

from __future__ import annotations

import hashlib
import http.client
import io
import math
import re
import statistics
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np
import orjson
import psycopg
from lxml import etree

from benchmarks.basex_client import BaseXClient
from benchmarks.xpath_library import Size
from benchmarks.xpath_questions import Question
from tests.postgres import server

Answer = float | list[str] | list[bytes]
"""A number; names or ids; or digests of nodes."""

_PAGE = 1000
_PARSER = etree.XMLParser(huge_tree=True, remove_blank_text=True)
"""Without the line breaks between elements, as BaseX and we see documents."""


class Ours:
    """The server, over one kept connection."""

    def __init__(self, process: int, port: int, size: Size) -> None:
        self.process = process
        self.documents = size.documents
        self._connection = http.client.HTTPConnection("127.0.0.1", port, timeout=120)

    def empty(self, number: int) -> None:
        self._get("/api/v1/xpath", [("q", f"1{number}")])

    def ask(self, question: Question, constants: dict[str, str], document: int | None) -> list[bytes]:
        """The answer, page after page where it comes in pages."""
        if question.form == "array":
            path = f"/api/v1/documents/{self.documents[document or 0]}/frames"
            return [self._get(path, [("format", "npy"), ("first", str(int(constants["k"]) + 1))])]
        query = [("q", question.asked(constants)), ("as", question.form)]
        if document is not None:
            query.append(("document", self.documents[document]))
        if question.form == "xml":
            return [self._get("/api/v1/xpath", query)]
        query.append(("limit", str(_PAGE)))
        pages = [self._get("/api/v1/xpath", query)]
        while (cursor := _next(pages[-1])) is not None:
            pages.append(self._get("/api/v1/xpath", [*query, ("cursor", cursor)]))
        return pages

    def edit(self, document: int, value: str) -> None:
        """One attribute of one sample."""
        self.empty(0)
        where = urlencode({"xpath": "/mcml/motion/frame[7]/frame_bone[2]"})
        self._connection.request(
            "PATCH",
            f"/api/v1/documents/{self.documents[document]}/elements?{where}",
            orjson.dumps({"attributes": {"Rx": value}}),
            {"content-type": "application/json", "if-match": "*"},
        )
        self._read()

    def same(self, question: Question, pages: list[bytes]) -> Answer:
        if question.form == "array":
            return [_digest(row[~np.isnan(row)]) for row in np.load(io.BytesIO(pages[0]))]
        if question.form == "xml":
            roots = [etree.fromstring(page, _PARSER) for page in pages]
            return _digests(question, (result[0] for root in roots for result in root))
        answers = [orjson.loads(page) for page in pages]
        items = [item for answer in answers for item in answer.get("items") or []]
        if question.form == "runs":
            return [str(id) for item in items for id in range(int(item["first_id"]), int(item["last_id"]) + 1)]
        if question.join == "distinct":
            return sorted(item["value"] for item in items)
        return float(answers[0].get("value", math.nan))

    def peak(self) -> float:
        """Most memory since `forget_peak`, MB, with the processes that the server started."""
        return sum(_status(process, "VmHWM") for process in self._processes()) / 1e3

    def resident(self) -> float:
        return sum(_status(process, "VmRSS") for process in self._processes()) / 1e3

    def forget_peak(self) -> None:
        for process in self._processes():
            Path(f"/proc/{process}/clear_refs").write_text("5")

    def _processes(self) -> list[int]:
        found = [self.process]
        for process in found:
            for task in Path(f"/proc/{process}/task").iterdir():
                found += [int(child) for child in (task / "children").read_text().split()]
        return found

    def _get(self, path: str, query: list[tuple[str, str]]) -> bytes:
        address = f"{path}?{urlencode(query)}"
        try:
            self._connection.request("GET", address)
            return self._read()
        except (http.client.RemoteDisconnected, ConnectionError):
            # The server closes connections at rest, here while the other engines were asked: never a timed one.
            self._connection.close()
            self._connection.request("GET", address)
            return self._read()

    def _read(self) -> bytes:
        response = self._connection.getresponse()
        content = response.read()
        if response.status >= 400:
            raise RuntimeError(f"{response.status}: {content[:2000].decode()}")
        return content


def _next(page: bytes) -> str | None:
    cursor: str | None = orjson.loads(page).get("next_cursor") if b'"next_cursor"' in page[-2000:] else None
    return cursor


class BaseX:
    """A database of a server. An empty request, too, opens it where the others do."""

    def __init__(self, client: BaseXClient, name: str, size: Size) -> None:
        self.client = client
        self.name = name
        # One after the other, so that they are in the order in which we answer; the indexes then at once.
        client.execute(f"CREATE DB {name}")
        for number in size.documents:
            client.execute(f"ADD TO {number:03}.xml {size.file(number)}")
        client.execute("OPTIMIZE")

    def empty(self, _: int) -> None:
        self.client.query(self.name, "()")

    def ask(self, question: Question, constants: dict[str, str], document: int | None) -> bytes:
        place = None if document is None else f"{self.name}/{document:03}.xml"
        return self.client.query(self.name, question.asked_of_basex(constants, place))

    def edit(self, document: int, value: str) -> None:
        place = f"doc('{self.name}/{document:03}.xml')/mcml/motion/frame[7]/frame_bone[2]/@Rx"
        self.client.query(self.name, f"replace value of node {place} with '{value}'")

    def same(self, question: Question, answer: bytes) -> Answer:
        if question.form in ("xml", "array"):
            return _digests(question, etree.fromstring(b"<r>" + answer + b"</r>", _PARSER))
        if question.join in ("distinct", "ids"):
            found = answer.decode().split()
            return sorted(found) if question.join == "distinct" else found
        return float(answer) if answer else math.nan


class Lxml:
    """One document, parsed beforehand. Parts of an answer are joined by `joined`."""

    def __init__(self, file: Path) -> None:
        self.tree = etree.parse(str(file), _PARSER)

    def ask(self, question: Question, constants: dict[str, str]) -> tuple[float, object]:
        """(seconds, what XPath gave). Attributes are made numbers where the question is about numbers."""
        start = time.perf_counter()
        found: Any = self.tree.xpath(question.asked_of_one(constants))
        if question.join in ("average", "most"):
            found = np.array([float(value) for value in found])
        return time.perf_counter() - start, found


def same_of_one(question: Question, found: object) -> Answer | np.ndarray:
    """What lxml or PostgreSQL found in one document, without holding on to its nodes."""
    if isinstance(found, np.ndarray | float):
        return found
    nodes: Any = found
    return _digests(question, nodes) if question.join == "nodes" else [str(value) for value in nodes]


def joined(question: Question, parts: list[Answer | np.ndarray]) -> Answer:
    """The answer for several documents."""
    if question.join in ("average", "most"):
        values = np.concatenate([np.asarray(part) for part in parts])
        if not len(values):
            return math.nan
        return float(values.max()) if question.join == "most" else math.fsum(values) / len(values)
    if question.join == "sum":
        return math.fsum(float(part) for part in parts)  # type: ignore[arg-type]  # numbers, by the question
    together: list[Any] = [item for part in parts for item in part]  # type: ignore[union-attr]  # lists, by the question
    return sorted(set(together)) if question.join == "distinct" else together


class Postgres:
    """Documents as xml in a table."""

    def __init__(self, address: str, size: Size) -> None:
        self._connection = psycopg.connect(address, autocommit=True)
        self._connection.execute("CREATE TABLE document (number int PRIMARY KEY, body xml)")
        for number in size.documents:
            text = size.file(number).read_text()
            self._connection.execute("INSERT INTO document VALUES (%s, xmlparse(document %s))", [number, text])

    def ask(self, question: Question, constants: dict[str, str], document: int | None) -> list[str | float | None]:
        nodes = "document, unnest(xpath(%s, body)) WITH ORDINALITY AS found(v, place)"
        where = "" if document is None else f" WHERE number = {document}"
        if question.join == "sum":
            select = f"SELECT sum((xpath(%s, body))[1]::text::float8) FROM document{where}"
        elif question.join in ("average", "most"):
            select = f"SELECT {'avg' if question.join == 'average' else 'max'}(v::text::float8) FROM {nodes}{where}"
        elif question.join == "distinct":
            select = f"SELECT DISTINCT v::text FROM {nodes}{where}"
        else:
            select = f"SELECT v::text FROM {nodes}{where} ORDER BY number, place"
        return [row[0] for row in self._connection.execute(select, [question.asked_of_one(constants)])]

    def same(self, question: Question, rows: list[str | float | None]) -> Answer:
        if question.join in ("sum", "average", "most"):
            return math.nan if rows[0] is None else float(rows[0])
        texts = [str(row) for row in rows]
        if question.join == "nodes":
            return _digests(question, (etree.fromstring(text, _PARSER) for text in texts))
        return sorted(texts) if question.join == "distinct" else texts


@contextmanager
def postgres(size: Size) -> Iterator[Postgres]:
    with server() as address:
        plain = address.format("postgres").replace("postgresql+psycopg", "postgresql")
        yield Postgres(plain, size)


def differ(one: Answer, other: Answer) -> bool:
    """Numbers may differ by the order in which they were added."""
    if isinstance(one, float) and isinstance(other, float):
        return not (math.isclose(one, other, rel_tol=1e-9) or (math.isnan(one) and math.isnan(other)))
    return one != other


def _digests(question: Question, nodes: Iterable[etree._Element]) -> list[bytes]:
    """Of each node, canonical; of an array's frame, its numbers."""
    if question.form == "array":
        return [
            _digest(np.array([float(value) for bone in frame for name, value in bone.items() if name != "name"]))
            for frame in nodes
        ]
    return [
        hashlib.blake2b(etree.tostring(node, method="c14n", with_tail=False), digest_size=8).digest() for node in nodes
    ]


def _digest(row: np.ndarray) -> bytes:
    """Of numbers in any order; of two zeros, neither has a sign."""
    return hashlib.blake2b(np.sort(row + 0.0).tobytes(), digest_size=8).digest()


def _status(process: int, what: str) -> float:
    """Kilobytes."""
    found = re.search(rf"{what}:\s+(\d+)", Path(f"/proc/{process}/status").read_text())
    return float(found[1]) if found else 0.0


def median_ms(seconds: list[float]) -> float:
    return statistics.median(seconds) * 1e3
