"""Base colours of glTF: factors, colours of vertices, and textures, looked up at the vertices.

Source: glTF 2.0 specification, section 3.9 (materials), Khronos Group 2021. Textures are read where Pillow is
installed.
"""

from __future__ import annotations

import base64
import binascii
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcml.errors import FormatError
from mcml.formats.colours import Pictures, sample_picture, to_linear
from mcml.formats.gltf.document import Document, as_number, as_numbers
from mcml.motion.skeleton import Array


class Colours:
    """The base colours of materials. left_out: why textures were not read."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._images: dict[int, NDArray[np.uint8] | None] = {}
        self._pictures = Pictures()
        self.left_out = self._pictures.left_out

    def of(self, material: object, count: int, uv: dict[int, Array]) -> Array:
        """(count, 3) linear base colours of the vertices of a primitive.

        material: its number, None for the default. uv: (count, 2) places in textures, by the number of their set.
        """
        facts = {} if material is None else self._document.item("materials", material)
        shine = facts.get("pbrMetallicRoughness")
        shine = shine if isinstance(shine, dict) else {}
        factor = as_numbers(shine.get("baseColorFactor", [1, 1, 1, 1]), 4, "baseColorFactor")[:3]
        colours = np.tile(factor, (count, 1))
        texture = shine.get("baseColorTexture")
        if isinstance(texture, dict):
            found = self._sample(texture, uv)
            if found is not None:
                colours = colours * found
        return colours

    def _sample(self, texture: dict[str, Any], uv: dict[int, Array]) -> Array | None:
        """(V, 3) linear colours of a texture at the vertices; its mean where they have no places in it."""
        facts = self._document.item("textures", texture.get("index"))
        if "source" not in facts:
            self.left_out.add("their kind is not read")
            return None
        image = self._image(as_number(facts["source"], "source"))
        if image is None:
            return None
        moves = (texture.get("extensions") or {}).get("KHR_texture_transform")
        at = uv.get(as_number(texture.get("texCoord", 0), "texCoord"))
        if at is None or moves:
            return np.asarray(to_linear(image).reshape(-1, 3).mean(axis=0))
        return sample_picture(image, at)

    def _image(self, number: int) -> NDArray[np.uint8] | None:
        if number not in self._images:
            self._images[number] = self._decode(self._document.item("images", number))
        return self._images[number]

    def _decode(self, facts: dict[str, Any]) -> NDArray[np.uint8] | None:
        """(height, width, 3) of sRGB; None, with the reason in `left_out`, where it is not read."""
        data = self._bytes(facts)
        if data is None:
            self.left_out.add("they are in files that are not sent along")
            return None
        return self._pictures.read(data)

    def _bytes(self, facts: dict[str, Any]) -> bytes | None:
        uri = facts.get("uri")
        if isinstance(uri, str) and uri.startswith("data:"):
            try:
                return base64.b64decode(uri.partition(",")[2], validate=True)
            except (binascii.Error, ValueError):
                return b""
        if "bufferView" not in facts:
            return None
        try:
            return self._document.bytes_of(facts["bufferView"])
        except FormatError:
            return b""
