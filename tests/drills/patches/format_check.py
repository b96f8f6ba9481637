"""Files are read, stored, changed, converted and given out in the new format."""

from pathlib import Path

import mcml
from mcml_service.storage.database import Database
from tests.builders import served

Path("a.plain").write_text("plain\nhead 0.0 1.5 0.0\nhand 0.5 1.0 0.25\nhead 0.0 1.5 0.125\nhand 0.5 1.0 0.5\n")
clip = mcml.read("a.plain")
assert (clip.format, list(clip.bones)) == ("plain", ["head", "hand"])

mcml.open("store.db").close()
with served(Database("sqlite:///store.db")) as client:
    api = "/api/v1"
    (plain,) = [one for one in client.get(f"{api}/formats").json()["items"] if one["name"] == "plain"]
    assert plain["reads"]
    assert plain["writes"]
    sent = [("file", ("a.plain", Path("a.plain").read_bytes()))]
    answer = client.post(f"{api}/documents", files=sent)
    assert answer.status_code == 201, answer.text
    uuid = answer.json()["documents"][0]["id"]
    same = client.get(f"{api}/documents/{uuid}/export", params={"format": "plain"})
    assert same.content == Path("a.plain").read_bytes()
    answer = client.patch(
        f"{api}/documents/{uuid}", json={"unit": "m", "frame_time": "0.01"}, headers={"if-match": "*"}
    )
    assert answer.status_code == 200, answer.text
    for target in ("trc", "plain", "glb", "mcml"):
        assert client.get(f"{api}/documents/{uuid}/export", params={"format": target}).status_code == 200, target
    trc = client.get(f"{api}/documents/{uuid}/export", params={"format": "trc"}).content
    answer = client.post(f"{api}/documents", files=[("file", ("b.trc", trc))])
    other = answer.json()["documents"][0]["id"]
    assert client.get(f"{api}/documents/{other}/export", params={"format": "plain"}).content.startswith(b"plain\n")
    asked = {"name": "for a friend", "documents": [uuid], "formats": ["plain"]}
    assert client.post(f"{api}/shares", json=asked).status_code == 201
    assert client.post(f"{api}/shares", json=asked | {"formats": ["plainer"]}).status_code >= 400
    wish = {"selection": {"documents": [uuid]}, "format": "plain"}
    assert client.post(f"{api}/exports", json=wish).status_code == 200
