"""The beats of an uploaded piece of music, for a dance to it."""

from __future__ import annotations

import json

from mcml.errors import LimitError, UnsupportedError
from mcml.formats.format import SourceFile
from mcml.processes.programs import run_reader
from mcml_schemas.analyses.dance import BeatsPerBar, Music
from mcml_schemas.jobs import MusicBeats
from mcml_service.analysis.dance.music import check_bpm, fit_tempo
from mcml_service.analysis.interface import AnalysisError
from mcml_service.settings import Settings

_WORKER = "mcml_service.actions.analysing.music_worker"
_KINDS = {"UnsupportedError": UnsupportedError, "LimitError": LimitError}


def read_music(
    file: SourceFile, settings: Settings, bpm: float | None = None, beats_per_bar: BeatsPerBar | None = None
) -> MusicBeats:
    """Return beats, tempo with its rivals, and whether it is even.

    Nothing is stored: pass values to the dance's parameters. bpm, beats_per_bar: known values of the music. Raises
    AnalysisError `music-undecodable`, `music-no-beats`; LimitError for more than 15 minutes; UnsupportedError if the
    extra `audio` is not installed.
    """
    seconds, memory = 2 * settings.read_seconds, settings.read_memory_mib << 20
    stated = [] if bpm is None else [repr(check_bpm(bpm))]
    with run_reader(
        _WORKER, file.name, str(seconds), *stated, stream=file.stream, seconds=seconds, memory=memory
    ) as answer:
        heard = json.load(answer)
    if "beats" not in heard:
        if heard["code"] in _KINDS:
            raise _KINDS[heard["code"]](heard["what"], remedy=heard["remedy"])
        raise AnalysisError(heard["code"], heard["what"], remedy=heard["remedy"])
    tempo = fit_tempo(heard["beats"])
    per_bar = beats_per_bar or heard["meters"][0]["beats_per_bar"]
    return MusicBeats(
        music=Music(beats=heard["beats"], beats_per_bar=per_bar, loudness=heard["loudness"]),
        bpm=tempo.bpm,
        even=tempo.even,
        residual_seconds=tempo.residual,
        bars=int(tempo.indices[-1]) // per_bar,
        clear=heard["clear"],
        rivals=heard["rivals"],
        meters=heard["meters"],
    )
