"""Frames of many clips as arrays."""

from __future__ import annotations

from typing import Literal, TypeAlias

from pydantic import ConfigDict, Field

from mcml_schemas.examples import PROJECT, shown
from mcml_schemas.jobs import Selection
from mcml_schemas.request_body import RequestBody

ArrayForm: TypeAlias = Literal["npz", "csv", "arrow", "parquet"]


class ArraysRequest(RequestBody):
    """Frame ranges of clips, and the numbers of each frame.

    Ranges are the selected clips as a whole, or the frame ranges of `query`.
    """

    model_config = ConfigDict(
        populate_by_name=True, json_schema_extra=shown({"selection": {"project": PROJECT}, "space": "positions"})
    )

    selection: Selection | None = Field(None, description="Clips; with `query` default all")
    query: str | None = Field(
        None,
        min_length=1,
        max_length=10_000,
        description="An XPath expression; the frame ranges of its answer are exported",
        examples=["//frame[motion_name='reach']"],
    )
    space: Literal["channels", "positions", "rotations"] = Field(
        "positions",
        description="Global joint positions (x y z), rotations (x y z w) by kinematics, or the channels of the files",
    )
    bones: list[str] = Field([], max_length=500, description="Bones by MCML name; default all, or none with quantities")
    quantities: list[str] = Field(
        [],
        max_length=100,
        description="Quantities of the body, as for frames: NAME:JOINT,JOINT or angle:NAME; beside channels only",
        examples=[["angle:left-knee-flexion"]],
    )
    columns: Literal["all", "shared"] = Field(
        "all", description="Columns of any clip, NaN where a clip lacks one; or columns that all clips share"
    )
    dtype: Literal["f8", "f4"] = Field("f4", description="Numbers of the arrays")
    guesses: Literal["yes", "no"] = Field("yes", description="no: the query leaves out clips that rest on a guess")
    as_: ArrayForm = Field("npz", alias="as", description="One npz or one table; arrow and parquet need `arrow`")
    raw: bool = Field(False, description="csv: also texts that spreadsheets take for formulas as they are")
