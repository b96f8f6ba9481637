"""Single elements over HTTP."""

from __future__ import annotations

from fastapi.testclient import TestClient

from tests.builders import MCML, bvh, one_kind, upload

API = "/api/v1"


def test_read_change_delete(client: TestClient) -> None:
    uuid = upload(client, {"hand.mcml": MCML})["documents"][0]["id"]
    address = f"{API}/documents/{uuid}/elements"
    one = {"xpath": "//frame[@id='5']/frame_bone[@name='left_up_leg']"}
    assert client.get(address, params=one).text == '<frame_bone name="left_up_leg" Rx="20.0" Ry="21.0" Rz="22.0"/>'
    assert client.patch(address, params=one, json={"attributes": {"Rx": "1.5"}}).status_code == 428
    edited = client.patch(
        address, params=one, json={"attributes": {"Rx": "1.5", "Rz": None}}, headers={"if-match": '"1"'}
    )
    assert edited.json() == {"address": "/mcml/motion/frame[3]/frame_bone[1]", "elements": 1, "revision": 2}
    assert client.get(address, params={"xpath": one["xpath"] + "/@Rx"}).text == "1.5"
    old = client.get(address, params={"xpath": "/mcml/motion/frame[3]/frame_bone[1]/@Rx", "revision": 1})
    assert old.text == "20.0"
    assert client.delete(address, params=one, headers={"if-match": "*"}).json()["revision"] == 3
    assert client.get(address, params=one).status_code == 404


@one_kind
def test_what_is_not_one_element_is_refused(client: TestClient) -> None:
    uuid = upload(client, {"hand.mcml": MCML})["documents"][0]["id"]
    address = f"{API}/documents/{uuid}/elements"
    for expression, status in (("//frame", 422), ("count(//frame)", 422), ("//nothing", 404), ("//frame[", 422)):
        answer = client.delete(address, params={"xpath": expression}, headers={"if-match": "*"})
        assert answer.status_code == status, expression
    refused = client.delete(address, params={"xpath": "//bone/name"}, headers={"if-match": "*"})
    assert refused.status_code == 422
    assert client.get(f"{API}/documents/{uuid}").json()["revision"] == 1


@one_kind
def test_ids_after_an_edit(client: TestClient) -> None:
    uuid = upload(client, {"a.bvh": bvh(9)})["documents"][0]["id"]
    address, head = f"{API}/documents/{uuid}/elements", {"if-match": "*"}

    def ids() -> list[int]:
        found = client.get(f"{API}/xpath", params={"q": "//frame/@id", "document": uuid, "limit": 50}).json()["items"]
        return [int(item["value"]) for item in found]

    refused = client.delete(address, params={"xpath": "//frame[4]", "gaps": "refuse"}, headers=head)
    assert refused.status_code == 422
    assert refused.json()["where"] == {"element": "/mcml/motion/frame[4]/@id"}
    assert ids() == list(range(1, 10))
    several = {"xpath": "//frame[position() mod 3 = 1]", "many": True, "renumber": True, "gaps": "refuse"}
    assert client.delete(address, params=several, headers=head).json()["elements"] == 3
    assert ids() == list(range(1, 7))
    assert client.delete(address, params={"xpath": "//frame[2]"}, headers=head).status_code == 200
    assert ids() == [1, 3, 4, 5, 6]
    batch = {"edits": [{"do": "delete", "xpath": "//frame[1]"}]}
    done = client.post(f"{address}/batch", json=batch, params={"gaps": "refuse"}, headers=head)
    assert done.status_code == 200, "what is left counts up by one"
