"""Details of documents on cards: pictures, spans of motion names, passports."""

from __future__ import annotations

import base64
from collections.abc import Sequence

from mcml_schemas.documents import Card, Passport, Span
from mcml_service.actions.reading.describe_document import summary
from mcml_service.actions.reading.show_thumbnails import Pictures
from mcml_service.storage.documents.documents import StoredDocument
from mcml_service.storage.transaction import Transaction

UNIT, UP = "calibration_unit", "global_axis_of_gravity"


def cards(tx: Transaction, documents: Sequence[StoredDocument], pictures: Pictures, also: frozenset[str]) -> list[Card]:
    """Return the cards of documents. also: details, of "thumbnail", "labels", "passport". pictures: existing ones."""
    keys = [stored.key for stored in documents]
    spans = tx.spans.of_many(keys) if "labels" in also else {}
    stated = tx.heads.read_texts(keys, (UNIT, UP)) if "passport" in also else {}
    joints = tx.heads.joints([stored.skeleton for stored in documents]) if "passport" in also else {}
    described = []
    for stored in documents:
        card = Card(**vars(summary(stored)))
        picture = pictures.get(stored.key)
        if "thumbnail" in also and picture is not None and picture.data:
            card.thumbnail = base64.b64encode(picture.data).decode()
        if "labels" in also:
            card.labels = [Span(name=name, first=first, last=last) for first, last, name in spans.get(stored.key, [])]
        if "passport" in also:
            facts = {} if picture is None else picture.facts
            card.passport = passport(stored, stated.get(stored.key, {}), joints[stored.skeleton], facts)
        described.append(card)
    return described


def passport(stored: StoredDocument, header: dict[str, str], joints: int, facts: dict[str, object]) -> Passport:
    """Return the passport of a document. header: values stated in its header. facts: guesses."""
    unit, up = header.get(UNIT), header.get(UP)
    guessed = {"unit": unit is None, "up": up is None, "rate": stored.seconds_per_frame is None}
    return Passport(
        unit=unit or facts.get("unit"),
        metres=facts.get("metres"),
        up=up or facts.get("up"),
        rate=None if stored.seconds_per_frame is None else 1 / stored.seconds_per_frame,
        joints=joints,
        markers=bool(facts.get("markers")),
        guessed=[name for name, is_guess in guessed.items() if is_guess],
    )
