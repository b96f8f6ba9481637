"""Reference video and audio of documents."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import HASH, shown
from mcml_schemas.request_body import RequestBody


class MediaInfo(BaseModel):
    """The reference file attached to a document."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {"name": "take 3.mp4", "media_type": "video/mp4", "bytes": 8391342, "sha256": HASH, "offset": 1.25}
        )
    )

    name: str
    media_type: str
    bytes: int
    sha256: str
    offset: float = Field(description="Seconds in it at the first frame of the motion")


class MediaChange(RequestBody):
    """Where the motion begins in it."""

    model_config = ConfigDict(json_schema_extra=shown({"offset": 1.3}))

    offset: float = Field(ge=-86_400, le=86_400, description="Seconds in it at the first frame of the motion")
