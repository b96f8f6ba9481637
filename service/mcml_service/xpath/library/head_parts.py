"""The heads of documents, part by part: headers read for each, skeletons once for all that share them."""

from __future__ import annotations

from collections.abc import Container, Sequence

from mcml_service.storage.documents.columns import Listed
from mcml_service.storage.transaction import Transaction
from mcml_service.xpath.language.reach import HeadPart
from mcml_service.xpath.library.cache import Cache
from mcml_service.xpath.nodes.heads import Subtree, first_part, flatten, motion_part


class Heads:
    """A cache of parts of heads, by last use: they never change under their keys, so none can be out of date.

    limit: in bytes. Threads may share it.
    """

    def __init__(self, limit: int) -> None:
        self._headers = Cache[tuple[int, int], Subtree](limit, lambda part: part.nbytes)
        self._skeletons = Cache[int, Subtree](4 * limit, lambda part: part.nbytes)

    def forget(self, held: Container[tuple[int, int]]) -> None:
        """Let the headers of all other documents go (key, revision)."""
        self._headers.forget(held.__contains__)

    def read(self, tx: Transaction, documents: Sequence[Listed], part: HeadPart) -> list[tuple[Subtree, ...]]:
        """The parts of the head of each document, one after the other: document and `mcml`, header, skeleton, motion,
        as far as they are needed.
        """
        firsts = [first_part(listed.version) for listed in documents]
        motions = [motion_part(listed.frames, listed.frame_time) for listed in documents]
        if part is HeadPart.MOTION:
            return list(zip(firsts, motions, strict=True))
        keys = {(listed.key, listed.revision): listed for listed in documents}

        def headers(missing: list[tuple[int, int]]) -> dict[tuple[int, int], Subtree]:
            found = tx.columns.headers([key for key, _ in missing])
            return {key: flatten([found[key[0]]]) for key in missing}

        def skeletons(missing: list[int]) -> dict[int, Subtree]:
            return {key: flatten(forest) for key, forest in tx.columns.skeletons(missing).items()}

        before = (firsts, self._headers.get(list(keys), headers))
        if part is HeadPart.HEADER:
            return list(zip(*before, motions, strict=True))
        return list(
            zip(*before, self._skeletons.get([one.skeleton for one in documents], skeletons), motions, strict=True)
        )
