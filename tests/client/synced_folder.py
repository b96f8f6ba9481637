"""A folder that tests sync with a project of a server."""

from __future__ import annotations

from pathlib import Path

from mcml.client.client import Client
from mcml.client.sync.bindings import STATE, Bindings
from mcml.client.sync.events import Event
from mcml.client.sync.folder_sync import FolderSync


class Synced:
    """A folder, synced in rounds; each `run` is a new process, as far as its memory goes."""

    def __init__(self, client: Client, folder: Path) -> None:
        self.client = client
        self.folder = folder
        folder.mkdir(exist_ok=True)

    def put(self, path: str, content: bytes) -> None:
        (self.folder / path).parent.mkdir(parents=True, exist_ok=True)
        (self.folder / path).write_bytes(content)

    def start(self, *, both: bool = False, client: Client | None = None) -> FolderSync:
        bindings = Bindings.read(self.folder, "here", "film")
        return FolderSync(client or self.client, self.folder, bindings, "film", {}, lambda *_: None, both=both)

    def run(self, *, both: bool = False) -> list[Event]:
        return list(self.start(both=both).run())

    def actions(self, *, both: bool = False) -> list[tuple[str, str]]:
        return sorted((event.action, event.path) for event in self.run(both=both))

    def names(self) -> list[str]:
        return sorted(item.name for item in self.client.every("list_documents", project="film").items)

    def uuid(self, name: str) -> str:
        items = self.client.every("list_documents", project="film", name=name).items
        return str(items[0].id)

    def files(self) -> list[str]:
        paths = (path for path in self.folder.rglob("*") if path.is_file() and path.name != STATE)
        return sorted(path.relative_to(self.folder).as_posix() for path in paths)

    def original(self, name: str) -> bytes:
        content = self.client.call("export_document", id=self.uuid(name), format="bvh")
        return b"".join(map(bytes, content.blocks))
