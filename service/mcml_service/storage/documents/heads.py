"""The light part of documents: header, root, skeleton, bone names, properties. Element by element, as rows."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from sqlalchemy import BigInteger, and_, bindparam, delete, exists, func, or_, select, update

from mcml.language.elements import Element, mcml_attributes
from mcml.motion.clip import seconds_from
from mcml_service.storage.core.schema import CURRENT
from mcml_service.storage.core.seals import closing, damage, verify
from mcml_service.storage.core.statements import Prepared
from mcml_service.storage.core.tables import bone, content, document, header, property_, skeleton, skeleton_element
from mcml_service.storage.core.transaction import BaseTransaction
from mcml_service.storage.core.validity import of_document
from mcml_service.storage.core.views import is_seen
from mcml_service.storage.documents.damage import name_document
from mcml_service.storage.documents.rows import ELEMENT_COLUMNS, SkeletonRows, to_elements, to_rows, to_skeleton

if TYPE_CHECKING:
    from mcml_service.storage.documents.columns import Listed
    from mcml_service.storage.documents.documents import StoredDocument

# Made once: to make a statement takes longer than to run a short one.
_HEADER = Prepared(
    select(header.c.level, header.c.tag, header.c.attributes, header.c.text)
    .where(of_document(header))
    .order_by(header.c.pre),
    header,
)
_ELEMENTS = skeleton_element.c
_SKELETON = Prepared(
    select(_ELEMENTS.level, _ELEMENTS.tag, _ELEMENTS.attributes, _ELEMENTS.text, skeleton.c.hash)
    .join(skeleton, skeleton.c.id == _ELEMENTS.skeleton)
    .where(skeleton_element.c.skeleton == bindparam("skeleton", type_=BigInteger))
    .order_by(skeleton_element.c.pre)
)
_BONE_NAMES = Prepared(select(bone.c.bone, bone.c.name).where(of_document(bone)).order_by(bone.c.bone), bone)
_EARLIER = content.alias()
_CLIPS_OF_SKELETON = Prepared(
    select(
        content.c.from_commit, document.c.id, document.c.uuid, document.c.name, content.c.version, content.c.skeleton,
        content.c.frames, content.c.frame_time, document.c.project,
    )
    .join(document, document.c.id == content.c.document)
    .where(content.c.skeleton == bindparam("skeleton", type_=BigInteger), document.c.state == "ready")
    .where(
        ~exists().where(
            _EARLIER.c.document == content.c.document,
            _EARLIER.c.skeleton == content.c.skeleton,
            _EARLIER.c.from_commit < content.c.from_commit,
        )
    )
    .order_by(document.c.id)
    .limit(bindparam("most", type_=BigInteger))
)  # fmt: skip
_EQUAL_SKELETON = Prepared(
    select(skeleton.c.id).where(skeleton.c.project == bindparam("project"), skeleton.c.hash == bindparam("hash"))
)


class Heads:
    def __init__(self, tx: BaseTransaction) -> None:
        self._tx = tx

    def header(self, document_key: int) -> Element:
        """The `header` element."""
        rows = self._tx.fetch_all(_HEADER, {"document": document_key, "at": self._tx.at})
        if not rows:
            raise damage(name_document(self._tx, document_key), "it has no header")
        return to_elements(rows)[0]

    def skeleton(self, skeleton_key: int) -> list[Element]:
        """The `root` element, if there is one, and the `skeleton` element."""
        rows = self._tx.fetch_all(_SKELETON, {"skeleton": skeleton_key})
        return to_skeleton([row[:-1] for row in rows], rows[0][-1] if rows else "")

    def document(self, stored: StoredDocument | Listed) -> Element:
        """The `mcml` element without its motion: header, root, skeleton."""
        children = [self.header(stored.key), *self.skeleton(stored.skeleton)]
        return Element("mcml", mcml_attributes(stored.version), "", children)

    def read_texts(self, documents: list[int], tags: tuple[str, ...]) -> dict[int, dict[str, str]]:
        """The texts of some elements of headers, by document and tag."""
        query = select(header.c.document, header.c.tag, header.c.text).where(
            header.c.document.in_(documents), header.c.tag.in_(tags), self._tx.valid(header)
        )
        texts: dict[int, dict[str, str]] = {}
        for key, tag, text in self._tx.fetch_all(verify(query, header)):
            texts.setdefault(key, {})[tag] = text
        return texts

    def seconds_per_frame(self, documents: Iterable[Listed]) -> dict[int, float | None]:
        """Seconds a frame of documents, by key: from the frame time, else from the header's rate; None without both."""
        listed = list(documents)
        texts = self.read_texts([each.key for each in listed if each.frame_time is None], ("dataframe_rate",))
        rates = {key: read["dataframe_rate"] for key, read in texts.items()}
        return {each.key: seconds_from(each.frame_time, rates.get(each.key)) for each in listed}

    def joints(self, skeletons: list[int]) -> dict[int, int]:
        """How many joints skeletons have."""
        query = select(skeleton.c.id, skeleton.c.joints).where(skeleton.c.id.in_(set(skeletons)))
        return {int(key): int(count) for key, count in self._tx.fetch_all(query)}

    def clips_of_skeleton(self, skeleton_key: int, most: int) -> list[tuple[int, Listed]]:
        """Return the first clips of a skeleton, deleted or not, each at the commit when it got the skeleton:
        (commit, clip).
        """
        from mcml_service.storage.documents.columns import Listed

        rows = self._tx.fetch_all(_CLIPS_OF_SKELETON, {"skeleton": skeleton_key, "most": most})
        return [
            (commit, Listed(key, uuid, name, version, own, frames, frame_time, revision=0, project=project))
            for commit, key, uuid, name, version, own, frames, frame_time, project in rows
        ]

    def bone_names(self, document_key: int) -> dict[int, str]:
        """Name of each bone number, the root's among them."""
        return dict(self._tx.fetch_all(_BONE_NAMES, {"document": document_key, "at": self._tx.at}))

    def write_header(self, document_key: int, element: Element, from_commit: int) -> None:
        """Make this the header from a commit on; the one before it is closed there. The last call in a commit wins."""
        if from_commit:
            current = (header.c.document == document_key, header.c.to_commit == CURRENT)
            self._tx.run(delete(header).where(*current, header.c.from_commit == from_commit))
            self._tx.run(update(header).where(*current).values(closing(header, from_commit)))
        names = ("document", "from_commit", "to_commit", *ELEMENT_COLUMNS)
        rows = [(document_key, from_commit, CURRENT, *row) for row in to_rows([element], level=1)]
        self._tx.insert_tuples(header, names, rows)
        if from_commit:
            self.refresh_properties(document_key, element)
        else:
            self._tx.insert_rows(property_, properties_of(document_key, element))

    def write_header_rows(self, document_key: int, rows: list[dict[str, Any]]) -> None:
        """Make these rows the header from this transaction's commit on."""
        current = (header.c.document == document_key, header.c.to_commit == CURRENT)
        commit = self._tx.commit
        self._tx.run(delete(header).where(*current, header.c.from_commit == commit))
        self._tx.run(update(header).where(*current).values(closing(header, commit)))
        made = {"document": document_key, "from_commit": commit, "to_commit": CURRENT}
        self._tx.insert_rows(header, [row | made for row in rows])
        self.refresh_properties(document_key, self.header(document_key))

    def refresh_properties(self, document_key: int, element: Element) -> None:
        """Make the searchable properties those of the current header."""
        self._tx.run(delete(property_).where(property_.c.document == document_key))
        self._tx.insert_rows(property_, properties_of(document_key, element))

    def add_skeleton(self, project_key: int, made: SkeletonRows, joints: int) -> int:
        """The key of this skeleton in the project: the stored one where an equal one is stored."""
        wanted = {"project": project_key, "hash": made.hash}
        rows = self._tx.fetch_all(_EQUAL_SKELETON, wanted)
        if not rows:
            # Another import may be storing an equal one: after waiting for it, its row is used.
            self._tx.order()
            rows = self._tx.fetch_all(_EQUAL_SKELETON, wanted)
        if rows:
            return int(rows[0][0])
        key = self._tx.insert_row(skeleton, project=project_key, hash=made.hash, joints=joints)
        self._tx.insert_tuples(skeleton_element, ("skeleton", *ELEMENT_COLUMNS), [(key, *row) for row in made.rows])
        return key

    def write_bones(self, document_key: int, names: list[str], from_commit: int) -> None:
        """Number the bones of a new document in skeleton order, root first."""
        columns = ("document", "bone", "from_commit", "to_commit", "name")
        rows = [(document_key, number, from_commit, CURRENT, name) for number, name in enumerate(names)]
        self._tx.insert_tuples(bone, columns, rows)

    def rename_bone(self, document_key: int, number: int, name: str) -> None:
        """Give a bone another name from this transaction's commit on."""
        self.close_bone(document_key, number)
        row = {"document": document_key, "bone": number, "from_commit": self._tx.commit, "to_commit": CURRENT}
        self._tx.insert_rows(bone, [row | {"name": name}])

    def add_bone(self, document_key: int, name: str) -> None:
        """A bone more, from this transaction's commit on, under a number that no bone of the document ever had."""
        newest = select(func.coalesce(func.max(bone.c.bone), -1)).where(bone.c.document == document_key)
        number = int(self._tx.fetch_value(newest)) + 1
        row = {"document": document_key, "bone": number, "from_commit": self._tx.commit, "to_commit": CURRENT}
        self._tx.insert_rows(bone, [row | {"name": name}])

    def close_bone(self, document_key: int, number: int) -> None:
        """The document has this bone no more, from this transaction's commit on."""
        valid = and_(bone.c.document == document_key, bone.c.bone == number, bone.c.to_commit == CURRENT)
        self._tx.run(update(bone).where(valid).values(closing(bone, self._tx.commit)))

    def skeletons(self, project_key: int | None, after: int, limit: int) -> list[Any]:
        """Rows (id, hash, joints, project, documents) of skeletons in use, by key, after a key."""
        used = and_(content.c.document == document.c.id, content.c.to_commit == CURRENT)
        query = (
            select(
                skeleton.c.id,
                skeleton.c.hash,
                skeleton.c.joints,
                skeleton.c.project,
                func.count(document.c.id).label("documents"),
            )
            .join(content, content.c.skeleton == skeleton.c.id)
            .join(document, used)
            .where(document.c.state == "ready", document.c.deleted_commit == CURRENT, skeleton.c.id > after)
            .where(is_seen(self._tx.view))
            .where(or_(project_key is None, skeleton.c.project == project_key))  # type: ignore[arg-type]
            .group_by(skeleton.c.id, skeleton.c.hash, skeleton.c.joints, skeleton.c.project)
            .order_by(skeleton.c.id)
            .limit(limit)
        )
        return self._tx.fetch_all(query)


def properties_of(document_key: int, element: Element) -> list[dict[str, Any]]:
    """The rows that make the properties of a header searchable."""
    rows: dict[str, dict[str, Any]] = {}
    for child in element.children:
        if child.tag == "property":
            value = child.attributes["value"]
            rows[child.attributes["name"]] = {
                "document": document_key,
                "name": child.attributes["name"],
                "number": _number(value),
                "text": value,
                "unit": child.attributes.get("unit", ""),
            }
    return list(rows.values())


@lru_cache(maxsize=4096)
def _number(text: str) -> float | None:
    try:
        value = float(text)
    except ValueError:
        return None
    return value if abs(value) < float("inf") else None
