"""Random insertions, replacements, moves and batches equal the same edits made with lxml; who comes late is merged."""

from __future__ import annotations

import copy
import io
from random import Random

import pytest
from fastapi.testclient import TestClient
from lxml import etree

from mcml.errors import McmlError
from mcml.language.dtd import violations
from mcml.language.fragment import read_fragment
from mcml_service.actions.editing.element_edits import Deletion, ElementEdit, Insertion, Replacement, edit_elements
from mcml_service.actions.editing.single_element import Change
from mcml_service.storage.database import Database
from tests.actions.test_frame_ranges import content, motion
from tests.actions.test_single_element import PARSER, canonical
from tests.builders import MCML, bvh, one_kind, store
from tests.edits import OTHER_SEEDS

pytestmark = pytest.mark.above_store

API = "/api/v1"
ANY = {"if-match": "*"}


def counted(tree: etree._Element) -> etree._Element:
    frames = str(len(motion(tree).findall("frame")))
    bones = str(len(list(tree.iter("root", "bone"))))
    for path, count in (("motion/frames", frames), ("header/num_frames", frames), ("header/num_segments", bones)):
        if tree.find(path) is not None:
            tree.find(path).text = count
    return tree


def address(node: etree._Element) -> str:
    steps = []
    while node is not None:
        parent = node.getparent()
        same = [] if parent is None else parent.findall(node.tag)
        always = node.tag in ("frame", "frame_bone")
        steps.append(node.tag + (f"[{same.index(node) + 1}]" if len(same) > 1 or (same and always) else ""))
        node = parent
    return "/" + "/".join(reversed(steps))


def some(chance: Random, tree: etree._Element) -> tuple[str, str, bytes]:
    """(address, where, fragment) of an insertion that may be allowed."""
    frames = motion(tree).findall("frame")
    frame = chance.choice(frames)
    kind = chance.randrange(6)
    if kind == 2 and frame.find("frame_bone") is None:
        kind = 0
    if kind == 0:
        copies = chance.sample(frames, min(len(frames), chance.choice([1, 2, 5])))
        return address(frame), chance.choice(["before", "after"]), b"".join(etree.tostring(f) for f in copies)
    if kind == 1:
        return address(frame), "into", b"<motion_name>%b</motion_name>" % chance.choice([b"hop", b"run"])
    if kind == 2:
        bones = frame.findall("frame_bone")
        new = copy.deepcopy(chance.choice(bones))
        new.set("Rx", "7.25")
        return address(chance.choice(bones)), chance.choice(["before", "after"]), etree.tostring(new)
    if kind == 3:
        return "/mcml/motion", "into", etree.tostring(frame)
    if kind == 4:
        return "/mcml/header", "into", b'<property name="age" value="%d"/>' % chance.randrange(99)
    bone = chance.choice(list(tree.iter("bone")))
    name = chance.choice([b"tail", b"ear", b"left_hand"])
    return address(bone), chance.choice(["after", "into"]), b"<bone><name>%b</name></bone>" % name


def put(tree: etree._Element, where: str, place: str, fragment: bytes) -> None:
    target = tree.xpath(where)[0]
    new = list(etree.fromstring(b"<x>" + fragment + b"</x>", PARSER))
    if place == "into":
        index = len(target)
        if new[0].tag == "motion_name":
            index = len(target.findall("motion_name"))
        for step, element in enumerate(new):
            target.insert(index + step, element)
        return
    index = target.getparent().index(target) + (place == "after")
    for step, element in enumerate(new):
        target.getparent().insert(index + step, element)


def edited_at_random(database: Database, seed: int, steps: int) -> None:
    chance = Random(seed)
    file = {"hand.mcml": MCML} if seed % 2 else {"chain.bvh": bvh(chance.choice([3, 270]), seed=seed)}
    uuid = store(database, file, labels=())[0]
    done = 0
    for _ in range(steps):
        before = content(database, uuid)
        tree = etree.fromstring(before, PARSER)
        edits: list[tuple[str, object]] = []
        where, place, fragment = some(chance, tree)
        what = chance.randrange(4)
        if what == 0:
            target = chance.choice(motion(tree).findall("frame") + list(motion(tree).iter("frame_bone"))[:50])
            new = copy.deepcopy(target)
            for bone in new.iter("frame_bone"):
                bone.set("Rz", "-3.5")
            edits = [(address(target), Replacement(tuple(read_fragment(etree.tostring(new)))))]
        elif what == 1:
            edits = [(where, Insertion(place, tuple(read_fragment(fragment)), renumber=False))]  # type: ignore[arg-type]
        else:
            bones = [bone for frame in motion(tree).findall("frame")[:40] for bone in frame.findall("frame_bone")]
            for bone in chance.sample(bones, min(4, len(bones))):
                edits.append((address(bone), chance.choice([Change({"Rx": "8.5"}), Deletion()])))
            if where.startswith("/mcml/header"):
                edits.append((where, Insertion(place, tuple(read_fragment(fragment)))))  # type: ignore[arg-type]
        try:
            with database.write() as tx:
                edit_elements(tx, tx.documents.get(uuid), [ElementEdit(a, w) for a, w in edits])  # type: ignore[arg-type]
        except McmlError:
            assert content(database, uuid) == before
            continue
        done += 1
        targets = [tree.xpath(item)[0] for item, _ in edits]
        for target, (_, made) in zip(targets, edits, strict=True):
            if isinstance(made, Change):
                target.set("Rx", "8.5")
            elif isinstance(made, Deletion):
                target.getparent().remove(target)
            elif isinstance(made, Replacement):
                target.getparent().replace(target, new)
            else:
                put(tree, where, place, fragment)
        after = content(database, uuid)
        assert violations(io.BytesIO(after)) == []
        assert canonical(etree.fromstring(after, PARSER)) == canonical(counted(tree)), edits
    assert done >= steps // 3
    assert database.check() == []


@pytest.mark.parametrize(("kind", "seed"), OTHER_SEEDS[:8], indirect=["kind"])
def test_random_edits(database: Database, seed: int) -> None:
    edited_at_random(database, seed, 18)


@pytest.mark.fuzz(seeds=50)
def test_random_edits_many_times(database: Database, seed: int) -> None:
    edited_at_random(database, seed, 100)


@pytest.fixture
def url(client: TestClient) -> str:
    answer = client.post(f"{API}/documents", files=[("file", ("walk.bvh", bvh(300)))], data={"label": "hop:5-9"})
    return f"{API}/documents/{answer.json()['documents'][0]['id']}"


def value(client: TestClient, q: str) -> object:
    return client.get(f"{API}/xpath", params={"q": q}).json()["value"]


@one_kind
def test_elements_over_http(client: TestClient, url: str) -> None:
    elements = f"{url}/elements"
    many = client.patch(
        elements,
        params={"xpath": "//frame[motion_name='hop']/frame_bone[@name='Spine']", "many": True},
        json={"attributes": {"Rx": "1.5"}},
        headers=ANY,
    )
    assert many.json() == {"address": "/mcml/motion/frame[5]/frame_bone[2]", "elements": 5, "revision": 2}
    assert value(client, "count(//frame_bone[@Rx = 1.5])") == 5
    frame = client.get(elements, params={"xpath": "//frame[5]"}).content
    made = client.post(elements, params={"xpath": "//frame[1]", "where": "before"}, content=frame + frame, headers=ANY)
    assert made.status_code == 200, made.text
    assert value(client, "count(//frame)") == 302
    assert value(client, "count(//frame[motion_name='hop'])") == 7
    put_back = client.put(elements, params={"xpath": "//frame[1]"}, content=frame.replace(b"hop", b"run"), headers=ANY)
    assert put_back.status_code == 200
    assert value(client, "string(//frame[1]/motion_name)") == "run"
    moved = client.post(
        f"{elements}/batch",
        json={"edits": [{"do": "move", "xpath": "//frame[1]", "to": "//frame[last()]", "where": "after"}]},
        headers=ANY,
    )
    assert moved.status_code == 200, moved.text
    assert value(client, "string(//frame[302]/motion_name)") == "run"
    gone = client.delete(elements, params={"xpath": "//frame[motion_name='hop']", "many": True}, headers=ANY)
    assert gone.json()["elements"] == 6
    assert value(client, "count(//frame)") == 296


@pytest.mark.parametrize(
    "fragment",
    [
        b"",
        b"text",
        b"<frame",
        b"<frame id='1'><frame_bone name='tail'/></frame>",
        b"<frame id='1'><frame_bone name='Spine' Rx='abc'/></frame>",
        b"<bone><name>x</name></bone>",
        b"<!DOCTYPE x [<!ENTITY e 'x'>]><frame id='&e;'/>",
        b"<frame><frame_bone name='Spine'/></frame>",
    ],
)
@one_kind
def test_what_may_not_stand_there_is_refused(client: TestClient, url: str, fragment: bytes) -> None:
    where = {"xpath": "//frame[2]", "where": "after"}
    answer = client.post(f"{url}/elements", params=where, content=fragment, headers=ANY)
    assert answer.status_code == 422, answer.text
    assert answer.json()["detail"]
    assert client.get(url).json()["revision"] == 1


FRAME_10 = {"xpath": "//frame[10]"}
TWICE = b"<frame id='1'><frame_bone name='Spine' Rx='1'/><frame_bone name='Spine' Rx='1'/></frame>"
FAULTS = [
    (b"<frame_bone name='tail' Rx='1'/>", "into", ["frame[10]/frame_bone[4]/@name"]),
    (b"<frame_bone name='Spine' Rx='abc' Ry='1' Rz='x'/>", "into", ["frame_bone[4]/@Rx", "frame_bone[4]/@Rz"]),
    (b"<motion_name>x</motion_name><motion_name>  </motion_name>", "into", ["frame[10]/motion_name[2]"]),
    (b"<frame_bone name='tail'/><frame_bone name='ear'/>", "into", ["frame_bone[4]/@name", "frame_bone[5]/@name"]),
    (b"<frame id='1'><frame_bone name='tail'/></frame>", "after", ["frame[11]/frame_bone[1]/@name"]),
    (b"<frame id='1'/><frame id='2'><frame_bone name='tail'/></frame>", "before", ["frame[11]/frame_bone[1]/@name"]),
    (b"<frame/><frame id='1'><x/></frame>", "after", ["frame[11]", "frame[12]/x[1]"]),
    (TWICE, "after", ["frame[11]"]),
]


@pytest.mark.parametrize(("fragment", "where", "places"), FAULTS)
@one_kind
def test_every_fault_is_told_where_it_would_stand(
    client: TestClient, url: str, fragment: bytes, where: str, places: list[str]
) -> None:
    answer = client.post(f"{url}/elements", params={**FRAME_10, "where": where}, content=fragment, headers=ANY)
    assert answer.status_code == 422, answer.text
    problem = answer.json()
    assert problem["where"]["element"].endswith(places[0])
    assert problem["where"].get("line") is None
    assert (f"{len(places)} faults" in problem["detail"]) == (len(places) > 1)
    for place in places if len(places) > 1 else ():
        assert place in problem["detail"]


@one_kind
def test_faults_in_the_head_have_addresses(client: TestClient, url: str) -> None:
    content = b'<property name="a"/><property value="b"/>'
    answer = client.post(f"{url}/elements", params={"xpath": "//header", "where": "into"}, content=content, headers=ANY)
    assert answer.status_code == 422
    detail = answer.json()["detail"]
    assert "/mcml/header/property[1]: " in detail
    assert "/mcml/header/property[2]: " in detail
    # The first of them: behind the files that it came from no property can stand.
    assert answer.json()["where"] == {"element": "/mcml/header"}


def test_all_or_nothing(client: TestClient, url: str) -> None:
    edits = [
        {"do": "change", "xpath": "//frame[3]/frame_bone[2]", "attributes": {"Rx": "1"}},
        {"do": "change", "xpath": "//frame[4]/frame_bone[2]", "attributes": {"Rx": "one"}},
    ]
    assert client.post(f"{url}/elements/batch", json={"edits": edits}, headers=ANY).status_code == 422
    assert client.get(url).json()["revision"] == 1


def test_two_people_at_once(client: TestClient, url: str) -> None:
    """Both read revision 1. Different elements: both succeed if the second asks to merge; the same: both are told."""
    elements, first = f"{url}/elements", {"if-match": '"1-json"'}

    def edit(where: str, text: str, **more: object) -> tuple[int, dict[str, object]]:
        params = {"xpath": where, **more}
        answer = client.patch(elements, params=params, json={"attributes": {"Rx": text}}, headers=first)  # type: ignore[arg-type]
        return answer.status_code, answer.json()

    one, two = "/mcml/motion/frame[50]/frame_bone[2]", "/mcml/motion/frame[60]/frame_bone[2]"
    assert edit(one, "1.5")[0] == 200
    assert edit(two, "2.5")[0] == 412
    assert edit(two, "2.5", merge=True)[0] == 200
    status, problem = edit(one, "9.5", merge=True)
    assert status == 409
    assert 'Rx="1.5"' in str(problem["detail"])
    # Frames that came before do not matter: the element is found where it now is.
    frame = client.get(elements, params={"xpath": "//frame[1]"}).content
    client.post(elements, params={"xpath": "//frame[1]", "where": "before"}, content=frame, headers=ANY)
    three = "/mcml/motion/frame[70]/frame_bone[2]"
    status, done = edit(three, "3.5", merge=True)
    assert (status, done["address"]) == (200, three.replace("70", "71"))
    values = [value(client, f"string(//frame[{n}]/frame_bone[2]/@Rx)") for n in (51, 61, 71)]
    assert values == ["1.5", "2.5", "3.5"]
    client.delete(elements, params={"xpath": "//frame[81]"}, headers=ANY)
    assert edit("/mcml/motion/frame[80]/frame_bone[2]", "1", merge=True)[0] == 409
