"""Requests of every operation about what one project has, which can be done by who may."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from fastapi.testclient import TestClient

from mcml_schemas.examples import example_of
from mcml_service.operations.operation import Operation, Right
from mcml_service.storage.database import Database
from tests.builders import upload
from tests.motion.bodies.made import person

API = "/api/v1"
Kind = Literal["thing", "named", "all", "own"]


@dataclass(frozen=True)
class Asked:
    """A request. kind: of a thing with an id; of what a project has under a name; of all that is seen, narrowed to the
    project where it can be; or of nothing of a project."""

    kind: Kind
    path: dict[str, Any]
    query: dict[str, Any]
    content: dict[str, Any]


@dataclass(frozen=True)
class Things:
    """What a project has. stored: documents, the last one deleted."""

    project: str
    stored: list[str]
    job: str
    result: str
    label: int
    comment: int
    proposal: int

    @property
    def id(self) -> str:
        return self.stored[0]


def labelled(client: TestClient, document: str, word: str) -> int:
    """The number of a new label."""
    label = {"name": word, "first": 2, "last": 4}
    made = client.post(f"{API}/documents/{document}/labels", json=[label], headers={"if-match": "*"})
    assert made.status_code == 201, made.text
    return int(made.json()["items"][0]["id"])


def commented(client: TestClient, document: str, text: str) -> int:
    """The number of a new comment."""
    made = client.post(f"{API}/documents/{document}/comments", json={"text": text, "first": 1, "bone": "Root"})
    assert made.status_code == 201, made.text
    return int(made.json()["id"])


def propose(client: TestClient, document: str, message: str) -> int:
    """The number of a new proposal."""
    body = {"edits": CHANGE["edits"] | {"message": message}}
    made = client.post(f"{API}/documents/{document}/proposals", json=body, headers={"if-match": "*"})
    assert made.status_code == 201, made.text
    return int(made.json()["number"])


def filled(client: TestClient, database: Database, project: str, word: str) -> Things:
    """Something of everything, each with a word in it."""
    change = {"if-match": "*"}
    files = {f"{word} {number}.bvh": person(number, 6) for number in range(3)}
    made: Any = upload(client, files, project=project)
    stored = [item["id"] for item in made["documents"]]
    label = labelled(client, stored[0], word)
    comment = commented(client, stored[0], word)
    proposal = propose(client, stored[0], word)
    for path, body in (
        (f"collections/{word}", {"documents": stored[:1]}),
        (f"queries/{word}", {"q": f"//frame[motion_name='{word}']"}),
        ("colours", {"items": {word: "sky"}}),
        (f"mappings/{word}", {"pairs": [{"source": "Root", "target": word}]}),
        ("aliases", {"items": [{"source": word, "name": "Root"}]}),
        ("vocabulary", {"items": [{"name": word, "description": word}]}),
    ):
        answer = client.put(f"{API}/{path}", params={"project": project}, json=body)
        assert answer.status_code < 300, answer.text
    media = {"file": (f"{word}.mp4", b"\0\0\0\x18ftypmp42" + bytes(64))}
    put = client.put(f"{API}/documents/{stored[0]}/media", files=media, headers=change)
    assert put.status_code == 200, put.text
    assert client.delete(f"{API}/documents/{stored[2]}", headers=change).status_code == 204
    with database.write() as tx:
        key = tx.projects.get(project)
        job = tx.jobs.add(key, "beats", word, word, [], {}, runner="nobody")
        result_key, result = tx.results.add(key, "beats", word, word, [], {}, {})
        tx.results.add_part(result_key, "speed", "curve", {"title": word, "series": []}, {"speed": np.zeros(3)})
    return Things(project, stored, job, result, label, comment, proposal)


CHANGE: dict[str, Any] = {
    "edits": {"edits": [{"do": "adjust", "first": 1, "last": 2, "channels": ["Rx"], "offset": 1}]}
}

CHANGING = {
    "change_document": {"description": "another"},
    "change_calibration": {"floor": 0.0},
    "change_media": {"offset": 1.5},
    "edit_frames": {"edits": [{"do": "delete", "first": 6, "last": 6}]},
    "put_frames": {"columns": ["Root.Rx"], "values": [[45.0]]},
    "add_labels": [{"name": "turn", "first": 1, "last": 1}],
    "change_label": {"name": "turned"},
    "change_element": {"attributes": {"Rx": "5"}},
    "edit_elements": {"edits": [{"do": "change", "xpath": "//frame[1]/frame_bone[1]", "attributes": {"Rx": "6"}}]},
    "make_changes": {"frames": [{"first": 2, "columns": ["Root.Rx"], "values": [[7.5]]}]},
    "split_document": {"at": [3]},
    "make_skeletons": {},
    "name_joints": {"items": [{"joint": "Root", "name": "Root"}]},
    "add_comment": {"text": "@reader look"},
    "change_comment": {"text": "look again"},
    "keep_presence": {"doing": "editing"},
    "create_proposal": CHANGE,
    "preview_changes": CHANGE,
}
"""Bodies of operations on one document."""

KEPT = ("/collections/{", "/queries/{", "/mappings/{", "/members/{")

NAMED = {
    "save_collection": {"documents": []},
    "save_query": {"q": "//frame"},
    "save_colours": {"items": {"walk": "sky"}},
    "save_mapping": {"pairs": [{"source": "Root", "target": "Spine"}]},
    "save_aliases": {"items": [{"source": "Hip", "name": "Root"}]},
    "save_vocabulary": {"items": [{"name": "hop", "colour": 3}]},
    "set_member": {"role": "reader"},
    "invite": {"role": "reader"},
}


def request_of(operation: Operation, things: Things, word: str) -> Asked | None:
    """How an operation is asked about what a project has; None for those that this cannot be asked of."""
    name, one, where = operation.name, things.id, {"project": things.project}
    selected = {"documents": [one]}
    if operation.path.startswith("/documents/{id}"):
        query: dict[str, Any] = {}
        path: dict[str, Any] = {"id": one}
        if "xpath" in [argument.name for argument in operation.arguments]:
            query["xpath"] = "//frame[1]/frame_bone[1]"
        query |= {
            "compare_revisions": {"before": 1}, "find_text": {"text": "frame"}, "export_document": {"format": "bvh"},
        }.get(name, {})  # fmt: skip
        content: dict[str, Any] = {"json": CHANGING[name]} if name in CHANGING else {}
        if "{label}" in operation.path:
            path["label"] = things.label
        if "{comment}" in operation.path:
            path["comment"] = things.comment
        if "{proposal}" in operation.path:
            path["proposal"] = things.proposal
        if name in ("replace_element", "insert_elements"):
            text = '<frame_bone name="Root" Rx="1"/>' if name == "replace_element" else "<motion_name>z</motion_name>"
            content = {"content": text, "headers": {"content-type": "application/xml"}}
        if name == "insert_elements":
            query["xpath"] = "//frame[1]"
        if name == "delete_element":
            query["xpath"] = "/mcml/motion/frame[last()]"
        if name == "put_media":
            content = {"files": {"file": ("b.mp4", b"\0\0\0\x18ftypmp42" + bytes(32))}}
        if name == "replace_file":
            # The file of `filled` that the document is of, with more frames.
            content = {"files": {"file": ("new.bvh", person(0, 8))}}
        if name == "restore_document":
            path["id"] = things.stored[2]
        if name == "use_standing_trial":
            content = {"json": {"selection": {"documents": [things.id]}}}
        if name == "retarget":
            content = {"json": {"skeleton": things.stored[1], "project": things.project}}
        return Asked("thing", path, query, content)
    if "/jobs/{id}" in operation.path:
        return Asked("thing", {"id": things.job}, {}, {})
    if "/results/{id}" in operation.path:
        body = {}
        if operation.method == "POST":
            (model,) = (argument.bare for argument in operation.arguments if argument.place == "body")
            body = {"json": example_of(model)}
        return Asked("thing", {"id": things.result, "part": "speed", "array": "speed"}, {}, body)
    if name in NAMED or operation.path in (
        "/collections/{name}",
        "/queries/{name}",
        "/mappings/{name:path}",
        "/members/{name}",
    ):
        body = NAMED.get(name, {})
        if name == "invite":
            return Asked("named", {}, {}, {"json": body | where})
        return Asked(
            "named", {"name": "reader" if "member" in name else word}, where, {"json": body} if name in NAMED else {}
        )
    if name == "change_project":
        return Asked("named", {}, where, {"json": {"archived": False}})
    if name in ("export_project", "get_project", "create_project"):
        return Asked("named", {}, where, {})
    if name == "add_share":
        return Asked("thing", {}, {}, {"json": {"name": "for them", "documents": [one]}})
    if name in ("get_colours", "get_aliases", "get_vocabulary", "delete_aliases", "delete_vocabulary", "list_members"):
        return Asked("named", {}, where, {})
    files = {"files": {"file": ("new.bvh", person(9, 4))}}
    csv = {"headers": {"content-type": "text/csv"}}
    asked: dict[str, Asked] = {
        "upload_documents": Asked("named", {}, {}, files | {"data": where}),
        "load_demo": Asked("named", {}, where | {"part": "walks"}, {}),
        "set_properties": Asked("thing", {}, {}, {"content": f"document,age\n{one},30\n", **csv}),
        "import_labels": Asked("thing", {}, {}, {"content": f"document,label,first,last\n{one},hop,1,1\n", **csv}),
        "delete_documents": Asked("thing", {}, {}, {"json": {"documents": [things.stored[1]]}}),
        "restore_documents": Asked("thing", {}, {}, {"json": {"documents": [things.stored[2]]}}),
        "copy_documents": Asked("thing", {}, {}, {"json": {"selection": selected, **where}}),
        "change_documents": Asked("thing", {}, {}, {"json": {"selection": selected, "change": {"description": "z"}}}),
        "export_documents": Asked("thing", {}, {}, {"json": {"selection": selected, "format": "bvh"}}),
        "label_by_query": Asked("thing", {}, {}, {"json": {"name": "all", "xpath": "//frame[1]", "document": [one]}}),
        "export_arrays": Asked("thing", {}, {}, {"json": {"selection": selected}}),
        "measure": Asked("thing", {}, {}, {"json": {"selection": selected, "quantities": ["position:Root,x"]}}),
        "post_query": Asked("thing", {}, {}, {"json": {"q": "//frame[1]", "document": [one]}}),
        "search_motion": Asked("thing", {}, {}, {"json": {"document": things.stored[1], "first": 1, "last": 3}}),
        "compose": Asked("thing", {}, {}, {"json": {"segments": [{"document": one, "first": 1, "last": 3}], **where}}),
        "retarget_many": Asked(
            "thing", {}, {}, {"json": {"selection": {"documents": [one]}, "skeleton": things.stored[1], **where}}
        ),
        "follow_path": Asked("thing", {}, {}, {"json": {"selection": selected, "path": [[0, 0], [1, 0]], **where}}),
        "get_matching_library": Asked("thing", {}, {}, {"json": {"selection": selected}}),
        "search_file": Asked("all", {}, {}, files),
        "complete_query": Asked("all", {}, {"q": "//frame[motion_name='"}, {}),
        "get_query_examples": Asked("all", {}, {}, {}),
        "get_quantity_range": Asked("all", {}, {"quantity": "position:Root,x"}, {}),
        "get_query": Asked("all", {}, {"q": "//bone/name | //header/filename | //motion_name"}, {}),
        "get_facets": Asked("all", {}, {}, {}),
        "compare_gait": Asked("thing", {}, {"document": one}, {}),
        "get_gait_report": Asked("thing", {}, {"document": one, "format": "csv"}, {}),
    }  # fmt: skip
    if operation.name.startswith("start_"):
        return Asked("thing", {}, {}, {"json": {"inputs": selected}})
    if name in asked:
        return asked[name]
    if name.startswith(("list_", "export_labels")) and operation.right is Right.READ:
        return Asked("all", {}, {}, {})
    return None


def send(client: TestClient, operation: Operation, asked: Asked) -> Any:
    path = operation.path.replace("{name:path}", "{name}").format(**asked.path)
    content = dict(asked.content)
    headers = {"if-match": "*", **content.pop("headers", {})}
    return client.request(operation.method, API + path, params=asked.query, headers=headers, **content)
