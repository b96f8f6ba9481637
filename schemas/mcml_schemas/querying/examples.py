"""Example queries, and ranges of quantities, from the motion of a library."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from mcml_schemas.examples import DOCUMENT, shown


class QueryExample(BaseModel):
    """An expression that finds frames. kind: of the sentence about it, to translate it; values: of the sentence."""

    kind: Literal[
        "activity",
        "speed-contact",
        "above-head",
        "angle",
        "then",
        "distance",
        "fastest",
        "height",
        "speed",
        "label",
        "no-label",
        "begin",
        "every",
    ]
    q: str = Field(description="XPath")
    about: str = Field(description="The frames that it finds, in English")
    values: dict[str, str | float] = Field(
        description="joint, other, angle, name, value, limit: joints, a name and numbers of the expression"
    )


class QueryExamples(BaseModel):
    """Examples, and a clip to show joints on."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "items": [
                    {
                        "kind": "speed",
                        "q": "//frame[mo:speed('left_hand') > 2]",
                        "about": "Left hand faster than 2 m/s",
                        "values": {"joint": "left_hand", "value": 2},
                    }
                ],
                "document": DOCUMENT,
            }
        )
    )

    items: list[QueryExample]
    document: str | None = Field(description="A clip with a body, of the same sample; null without clips")


class QuantityRange(BaseModel):
    """Quantiles of a quantity over the frames of a sample of clips; null where no clip has a value."""

    model_config = ConfigDict(
        json_schema_extra=shown(
            {
                "quantity": "speed:left_hand",
                "unit": "m/s",
                "clips": 32,
                "least": 0.0,
                "low": 0.02,
                "middle": 0.5,
                "high": 3.1,
                "most": 6.2,
            }
        )
    )

    quantity: str
    unit: str
    clips: int = Field(description="Clips of the sample with values")
    least: float | None = None
    low: float | None = Field(None, description="5 % of the frames are below it")
    middle: float | None = Field(None, description="Median")
    high: float | None = Field(None, description="5 % of the frames are above it")
    most: float | None = None
