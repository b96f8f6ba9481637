"""Music: its beats found, corrected, danced to."""

from __future__ import annotations

import io
import wave

import numpy as np
import pytest
from fastapi.testclient import TestClient

from mcml_service.actions.importing.load_demo import add_clips
from mcml_service.demo.dance_clips import dance_clip
from mcml_service.settings import Settings
from mcml_service.storage.database import Database
from tests.builders import one_kind
from tests.jobs.test_jobs import wait

API = "/api/v1"
pytestmark = [one_kind, pytest.mark.usefixtures("lent_workers")]


def clicks(bpm: float, seconds: float = 40.0, rate: int = 22050) -> bytes:
    """Short tones on every beat, from half a second on, as WAV."""
    time = np.arange(round(seconds * rate)) / rate
    sound = np.zeros_like(time)
    for beat in np.arange(0.5, seconds - 0.1, 60 / bpm):
        since = time - beat
        sound += np.where(
            (since >= 0) & (since < 0.05), np.sin(2 * np.pi * 1000 * since) * np.exp(-80 * np.clip(since, 0, 1)), 0.0
        )
    stream = io.BytesIO()
    with wave.open(stream, "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes((sound * 20000).astype("<i2").tobytes())
    return stream.getvalue()


@pytest.mark.fuzz  # Long: in `make test` the browser goes this way (tests/web/test_dance.py).
def test_from_music_to_dance(client: TestClient, database: Database) -> None:
    answer = client.post(f"{API}/music", files={"file": ("song.wav", clicks(116))})
    assert answer.status_code == 200, answer.text
    found = answer.json()
    assert found["even"]
    assert found["bpm"] == pytest.approx(116, rel=0.003)
    music = found["music"]
    assert len(music["loudness"]) == len(music["beats"])
    assert max(music["loudness"]) > 0
    beats = np.array(music["beats"])
    assert abs(((beats - 0.5) / (60 / 116) + 0.5) % 1 - 0.5).max() * 60 / 116 < 0.06
    dances = [dance_clip("groove", tempo=tempo, bars=8, name=f"dance_{tempo}").clip for tempo in (110, 120)]
    add_clips(database, Settings(), "dances", dances, (), "")
    # The user says that the first bar begins with the third beat, and saves that as a dance of four bars.
    body = {"inputs": {"project": "dances"}, "parameters": {"music": music | {"downbeat": 3}, "bars": 4}}
    done = wait(client, client.post(f"{API}/analyses/dance", json=body).json())
    assert done["state"] == "done", done
    result = client.get(f"{API}/results/{done['result']}").json()
    document = client.get(f"{API}/documents/{result['parts']['clip']['document']}").json()
    start = beats[2]
    assert document["duration"] == pytest.approx(start + 16 * 60 / found["bpm"], abs=0.15)
    assert client.get(f"{API}/documents/{document['id']}/export", params={"format": "bvh"}).status_code == 200


@pytest.mark.slow
def test_what_is_no_music_is_refused(client: TestClient) -> None:
    """By the process that reads it; what else is refused, tests of the analysis say."""
    answer = client.post(f"{API}/music", files={"file": ("cut.wav", clicks(120)[:40])})
    assert (answer.status_code, answer.json()["code"]) == (422, "music-undecodable"), answer.text
    assert answer.json()["detail"] == "cut.wav begins as sound does, but is cut off or damaged."
    assert answer.json()["remedy"]


@pytest.mark.slow
def test_rivals_are_told_and_what_is_known_is_taken(client: TestClient) -> None:
    file = {"file": ("song.wav", clicks(116, 20.0))}
    found = client.post(f"{API}/music", files=file).json()
    assert {"1", "2", "1/2"} <= {rival["ratio"] for rival in found["rivals"]}
    assert found["rivals"][0]["bpm"] == pytest.approx(found["bpm"], rel=0.01)
    half = client.post(f"{API}/music", files=file, data={"bpm": "58", "beats_per_bar": "3"}).json()
    assert half["bpm"] == pytest.approx(58, rel=0.02)
    assert half["clear"]
    assert (half["music"]["beats_per_bar"], half["bars"]) == (3, (len(half["music"]["beats"]) - 1) // 3)
    for wrong in ({"bpm": "900"}, {"beats_per_bar": "7"}, {"bpm": "fast"}):
        assert client.post(f"{API}/music", files=file, data=wrong).status_code == 422
