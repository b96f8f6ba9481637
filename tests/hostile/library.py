"""A store with something of everything, and requests that speak of what it holds."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any
from urllib.parse import quote

import numpy as np
from fastapi.testclient import TestClient
from hypothesis import strategies as st
from schemathesis import Case

from mcml.files.import_options import Label
from mcml_schemas.jobs import Selection
from mcml_service.actions.analysing.start_analysis import find_analysis, start_analysis
from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.analysis.catalogue import ANALYSES
from mcml_service.demo.face_takes import EXPRESSIONS, face_takes
from mcml_service.demo.reach_clips import reach_clips
from mcml_service.jobs.runner import run_here
from mcml_service.settings import Settings
from mcml_service.storage.core.identifiers import new_uuid
from mcml_service.storage.database import Database
from mcml_service.xpath.queries import Queries
from tests.builders import ASF, HTR, MCML, TRC, amc, bvh, c3d_file, mcml_of, store

API = "/api/v1"
ENDED = ("done", "failed", "cancelled")

FILES = {
    "hand.mcml": MCML, "odd.mcml": mcml_of([3, 3, -1, 7, 7]), "walk.bvh": bvh(30), "one.bvh": bvh(1), "arm.htr": HTR,
    "hand.trc": TRC, "points.c3d": c3d_file(), "leg.asf": ASF, "leg.amc": amc(4),
}  # fmt: skip
FEWEST = 12
"""Documents that there are at least."""

HOME = "http://127.0.0.1:8000"
ROLES = {"owner": "operate", "reader": "read"}
"""Of the people who ask, and the scopes of their tokens."""

XPATHS = (
    "//frame", "//frame[2]", "//frame[1]/frame_bone[1]", "//frame_bone[@name='Root']/@Rx", "/mcml/motion/frame[last()]",
    "//frame[motion_name='walk']", "//motion_name[1]", "//bone/name", "/mcml/header", "/mcml/header/filename/text()",
    "count(//frame)", "max(//frame_bone/@Rx)", "//frame[frame_bone/@Ry > 1]", "//frame[@id='3']", "/mcml/root/@order",
    "/mcml/skeleton/bone[1]", "//frame/following-sibling::frame[1]", "for $f in //frame return $f/@id", "/", "//*",
)  # fmt: skip
FRAGMENTS = (
    '<frame id="9"/>', '<frame id="9"><motion_name>hop</motion_name></frame>', "<motion_name>hop</motion_name>",
    '<frame_bone name="Root" Rx="1.25"/>', '<frame_bone name="left_up_leg" Rx="1e308" Ry="-0"/>', "<frame",
    '<bone id="77"><name>spine1</name></bone>', "<filename>b.mcml</filename>", "",
)  # fmt: skip


def _array(shape: tuple[int, ...]) -> bytes:
    written = io.BytesIO()
    np.save(written, np.ones(shape))
    return written.getvalue()


TABLES = (
    "document,label,first,last\n", "document,label,first\n", "document,take,age (year),height (cm)\n",
    "document,a,b,a\n",
    "name,age\n", "", 'document,"\n', "document,label,first,last\nhand.mcml,hop,2,900\n", "document,\0,b,c\n",
)  # fmt: skip
OPERATIONS = {name: analysis.name for analysis in ANALYSES.values() for name in analysis.operations}
"""The analysis whose results an operation asks."""

CONTENTS: dict[str, st.SearchStrategy[Any]] = {
    "application/xml": st.sampled_from(FRAGMENTS),
    "application/octet-stream": st.sampled_from([_array((2, 1)), _array((1, 2)), _array((3,)), b"", b"\x93NUMPY"]),
}
"""What is sent that is not JSON, by its media type."""

SOME: dict[str, st.SearchStrategy[Any]] = {
    **dict.fromkeys(("xpath", "q"), st.sampled_from(XPATHS)),
    **dict.fromkeys(("first", "last", "frame", "at", "to", "rows", "step"), st.integers(1, 8)),
    **dict.fromkeys(("revision", "before", "after"), st.integers(1, 3)),
    **dict.fromkeys(("project", "name"), st.sampled_from(["default", "reach", "faces", "walk", "other"])),
    **dict.fromkeys(("motion_name", "label", "instead_of"), st.sampled_from(["walk", "left-leg-flexion", "hop"])),
    **dict.fromkeys(("bone", "bones", "source", "target"), st.sampled_from(["Root", "left_up_leg", "Hips", "Head"])),
    **dict.fromkeys(("channel", "channels"), st.sampled_from(["Rx", "Ry", "Rz", "Tx"])),
    "column": st.sampled_from(["Root.Rx", "Root.Tx", "left_up_leg.Rx"]),
    "property": st.sampled_from(["age:20..30", "take:calm"]),
    "limit": st.integers(1, 5),
    "fragment": st.sampled_from(FRAGMENTS),
    "attributes": st.dictionaries(st.sampled_from(["Rx", "Ry", "id", "name"]), st.sampled_from(["1", "-2.5", "x"])),
    "if-match": st.sampled_from(["*", "*", "*", '"1"', '"2"', 'W/"1"']),
}
"""What means something in a store, by the name that parameters and fields have for it."""

MOSTLY = st.sampled_from([True, True, True, False])

Draw = Callable[[st.SearchStrategy[Any]], Any]


class Library:
    """What a store holds, by kind; looked up anew before each operation."""

    def __init__(self, client: TestClient, database: Database, settings: Settings, analyses: dict[str, Any]) -> None:
        """Fill an empty store: documents of every format, labels, a mapping, jobs that ended and one that waits,
        a result of each analysis that is named, with its parameters."""
        self._client, self._database, self._settings = client, database, settings
        clips = {
            "reach": lambda: [item.clip for item in reach_clips(3, young=(2, 2), old=(2, 2))],
            "expression": lambda: [t.clip for t in face_takes(2, expressions=EXPRESSIONS[:2], every_marker=8, fps=24)],
        }
        for name, parameters in analyses.items():
            add_clips(database, settings, name, clips[name](), (), "")
            self._analyse(name, parameters, new_uuid())
        self._analyse(name, parameters, None)
        self._people: dict[str, str] = {}
        self._joined = 0

    def _analyse(self, name: str, parameters: dict[str, Any], runner: str | None) -> None:
        queries, selection = Queries(self._database, self._settings), Selection(project=name)
        uuid = start_analysis(
            self._database,
            queries,
            self._settings,
            find_analysis(name),
            selection,
            parameters,
            author="a",
            runner=runner,
        )  # fmt: skip
        queries.close()
        if runner is not None:
            with self._database.read() as tx:
                job = tx.jobs.get(uuid)
            run_here(self._database, self._settings, job, runner, lambda stage, share: None)

    def refill(self) -> None:
        """Store again what requests have deleted, and look what there is."""
        if self._items("documents?limit=1", "total") < FEWEST:
            store(self._database, FILES, labels=(Label("walk", 1, 1),))
        if not self._items("mappings"):
            pairs = {"pairs": [{"source": "Root", "target": "Root"}]}
            self._client.put(f"{API}/mappings/walk", json=pairs)
        self._look_for_people()
        self._named = {
            kind: [item["name"] for item in self._items(kind)]
            for kind in ("accounts", "tokens", "collections", "queries", "mappings")
        }
        self._invitations = [item["number"] for item in self._items("invitations")]
        jobs, results = self._items("jobs?limit=20"), self._items("results?limit=20")
        present = [item["id"] for item in self._items("documents?limit=20")]
        deleted = [item["id"] for item in self._items("documents?deleted=true&limit=3")]
        self._documents = [*present, *present, *deleted]
        self._jobs = [job["id"] for job in jobs]
        # The events of others would be followed for ever: nobody works on them.
        self._ended = [job["id"] for job in jobs if job["state"] in ENDED]
        self._results = {result["id"]: result["analysis"] for result in results}
        self._labels = [
            {"id": one, "label": label["id"]}
            for one in present[:6]
            for label in self._items(f"documents/{one}/labels?limit=5")
        ]
        self._parts = [
            {"id": result["id"], "part": name, "array": array}
            for result in results
            for name, part in self._client.get(f"{API}/results/{result['id']}").json()["parts"].items()
            for array in [*part.get("arrays", ()), "nothing"]
        ]

    def _look_for_people(self) -> None:
        """Let there be somebody of each role, whatever requests have done to those before."""
        for role, scope in ROLES.items():
            bearer = {"authorization": f"Bearer {self._people.get(role)}"}
            asked = self._client.get(f"{API}/account", headers=bearer)
            if asked.status_code != 200 or asked.json().get("role") != role:
                self._people[role] = self._join(role, scope)

    def _join(self, role: str, scope: str) -> str:
        """The token of somebody new."""
        self._joined += 1
        name = f"{role} {self._joined}"
        browser = TestClient(self._client.app, HOME, headers={"origin": HOME}, client=("10.0.0.7", 50_000))
        # Of the second one on it is refused: there is an owner.
        self._client.post(f"{API}/accounts", json={"name": "keeper", "password": "four words in a row"})
        code = self._client.post(f"{API}/invitations", json={"role": role}).json()["code"]
        browser.post(f"{API}/session", json={"invitation": code, "name": name, "password": "four words in a row"})
        made = browser.post(f"{API}/tokens", json={"name": f"{name}'s", "scope": scope})
        return str(made.json()["token"])

    def _items(self, path: str, key: str = "items") -> Any:
        return self._client.get(f"{API}/{path}").json()[key]

    def fill(self, case: Case, draw: Draw) -> None:
        """Put what there is in place of most of what a request names, and let others than the store's owner ask."""
        for name in case.path_parameters:
            known = self._known_in_path(case.path, name)
            if known:
                case.path_parameters[name] = quote(str(draw(st.sampled_from(known))), safe="")
        together = self._parts if "{array}" in case.path else self._labels if "{label}" in case.path else []
        if together and draw(MOSTLY):
            case.path_parameters.update(draw(st.sampled_from(together)))
        self.fill_contents(case, draw)

    def fill_contents(self, case: Case, draw: Draw) -> None:
        """The same of all but the address."""
        if not draw(MOSTLY):
            case.headers["authorization"] = f"Bearer {draw(st.sampled_from(sorted(self._people.values())))}"
        case.query = self._filled(case.query, "", draw)
        if case.path.endswith("/v1/events"):
            # They go on for ever.
            case.query = {**(case.query or {}), "seconds": 0}
        if any(header.name == "if-match" for header in case.operation.headers) and draw(MOSTLY):
            case.headers["if-match"] = draw(SOME["if-match"])
        shown = case.operation.definition.raw.get("requestBody", {}).get("content", {}).get(case.media_type, {})
        if "json" in str(case.media_type) and "example" in shown and draw(st.booleans()):
            case.body = shown["example"]
        if case.media_type == "text/csv" and self._documents:
            rows = (draw(st.sampled_from(self._documents)) for _ in range(2))
            case.body = draw(st.sampled_from(TABLES)) + "".join(f"{one},walk,1,2\n" for one in rows)
        elif case.media_type in CONTENTS:
            case.body = draw(CONTENTS[case.media_type])
        elif case.media_type == "multipart/form-data" and isinstance(case.body, dict):
            files = draw(st.lists(st.sampled_from(sorted(FILES)), min_size=1, max_size=2))
            case.body = {**self._filled(case.body, "", draw), "file": files}
        elif isinstance(case.body, dict | list):
            case.body = self._filled(case.body, "", draw)

    def _known_in_path(self, path: str, name: str) -> list[Any]:
        if name == "id":
            kind, last = path.split("/")[3], path.rpartition("/")[2]
            if kind == "results" and last in OPERATIONS:
                return [one for one, analysis in self._results.items() if analysis == OPERATIONS[last]]
            if last == "events":
                return self._ended
            return {"documents": self._documents, "jobs": self._jobs, "results": list(self._results)}[kind]
        if name == "number":
            return self._invitations
        if name == "name":
            return self._named.get(path.split("/")[3], list(ANALYSES))
        return [part["part"] for part in self._parts] if name == "part" else []

    def _filled(self, value: Any, name: str, draw: Draw) -> Any:
        known = self._strategy(name)
        if isinstance(value, dict) and known is None:
            return {key: self._filled(item, key, draw) for key, item in value.items()}
        if isinstance(value, list):
            return [self._filled(item, name, draw) for item in value]
        return draw(known) if known is not None and value is not None and draw(MOSTLY) else value

    def _strategy(self, name: str) -> st.SearchStrategy[Any] | None:
        if name in ("document", "documents", "skeleton", "template") and self._documents:
            return st.sampled_from(self._documents)
        if name in ("parent", "extends") and self._results:
            return st.sampled_from(list(self._results))
        return SOME.get(name)
