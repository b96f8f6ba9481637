"""Cases of the W3C's suite (qt3tests) that need no document, and a judge that asks in XPath whether an answer is right.

A case is an expression and what its value must be. Each assertion is made an expression about `$result`, so whoever
answers expressions with true or false can be judged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from lxml import etree

NAMESPACE = "{http://www.w3.org/2010/09/qt-fots-catalog}"
SPECS = {"XP20+", "XP30+", "XP31", "XP31+", "XP30", "XP20"}
SATISFIED = {
    ("feature", "higherOrderFunctions"),
    ("feature", "namespace-axis"),
    ("feature", "arbitraryPrecisionDecimal"),
}


class RefusalError(Exception):
    """Whoever was asked has no answer, and says why."""


Ask = Callable[[str], bool]
"""Whether an expression is true. Raises RefusalError."""


@dataclass(frozen=True)
class Case:
    """name: set and case. wanted: the element of the assertion."""

    name: str
    expression: str
    wanted: etree._Element


def read_cases(folder: Path) -> Iterator[Case]:
    """Those without an environment that are of XPath 3.1, and need nothing that we do not have."""
    for path in sorted(folder.rglob("*.xml")):
        root = etree.parse(path, etree.XMLParser(remove_comments=True, remove_pis=True)).getroot()
        if root.tag != f"{NAMESPACE}test-set":
            continue
        common = root.findall(f"{NAMESPACE}dependency")
        for case in root.iter(f"{NAMESPACE}test-case"):
            asked, result = case.find(f"{NAMESPACE}test"), case.find(f"{NAMESPACE}result")
            if case.find(f"{NAMESPACE}environment") is not None or asked is None or result is None:
                continue
            if asked.get("file") is not None or case.find(f"{NAMESPACE}module") is not None:
                continue
            if all(map(_is_met, [*common, *case.findall(f"{NAMESPACE}dependency")])) and _is_of_xpath(case, common):
                yield Case(f"{root.get('name')}/{case.get('name')}", asked.text or "", result[0])


def _is_of_xpath(case: etree._Element, common: list[etree._Element]) -> bool:
    own = [one for one in case.findall(f"{NAMESPACE}dependency") if one.get("type") == "spec"]
    specs = own or [one for one in common if one.get("type") == "spec"]
    return all(one.get("satisfied") != "false" and _names_later(one.get("value", "")) for one in specs)


def _names_later(value: str) -> bool:
    return bool({"XP31", "XP31+", "XP30+", "XP20+"} & set(value.split()))


def _is_met(dependency: etree._Element) -> bool:
    kind, value = dependency.get("type", ""), dependency.get("value", "")
    if kind == "spec":
        return True
    is_there = (kind, value) in SATISFIED or kind in ("xml-version", "xsd-version", "unicode-version")
    return is_there == (dependency.get("satisfied", "true") == "true")


def judge(case: Case, ask: Ask) -> str:
    """ "right", "wrong" or "refused": of an answer where an error is expected, a refusal is right."""
    try:
        return "right" if _holds(case.wanted, case.expression, ask) else "wrong"
    except RefusalError:
        return "refused"


def _holds(wanted: etree._Element, expression: str, ask: Ask) -> bool:
    kind = etree.QName(wanted).localname
    if kind in ("all-of", "any-of"):
        found = []
        for part in wanted:
            try:
                found.append(_holds(part, expression, ask))
            except RefusalError:
                if kind == "all-of":
                    raise
                found.append(False)
        return all(found) if kind == "all-of" else any(found)
    if kind == "not":
        return not _holds(wanted[0], expression, ask)
    if kind == "error":
        try:
            ask(f"exists(({expression}\n)) or true()")
        except RefusalError:
            return True
        return False
    return ask(_assertion(kind, wanted, expression))


def _assertion(kind: str, wanted: etree._Element, expression: str) -> str:
    """What must be true."""
    text = wanted.text or ""
    result = f"(\n{expression}\n)"
    if kind == "assert":
        return f"let $result := {result} return boolean(({text}))"
    if kind == "assert-eq":
        return f"{result} eq ({text})"
    if kind == "assert-type":
        return f"{result} instance of {text}"
    if kind == "assert-count":
        return f"count({result}) eq {text}"
    if kind == "assert-empty":
        return f"empty({result})"
    if kind in ("assert-true", "assert-false"):
        return f"let $r := {result} return $r instance of xs:boolean and $r eq {kind.removeprefix('assert-')}()"
    if kind == "assert-deep-eq":
        return f"deep-equal({result}, ({text}))"
    if kind == "assert-permutation":
        return (
            f"let $r := {result}, $w := ({text}) return count($r) eq count($w) and "
            "(every $i in $w satisfies count($r[deep-equal(., $i)]) eq count($w[deep-equal(., $i)]))"
        )
    if kind == "assert-string-value":
        joined = f"string-join(for $r in {result} return string($r), ' ')"
        if wanted.get("normalize-space") == "true":
            joined, text = f"normalize-space({joined})", " ".join(text.split())
        return f"{joined} eq {_quoted(text)}"
    raise RefusalError(kind)


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"
