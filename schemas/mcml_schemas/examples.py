"""Data of the examples in the API description: one short walk, as shown by every endpoint."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel

DOCUMENT = "01a1fd5b-63fa-7af5-9027-3f8ccdfe4736"
JOB = "01a1fd7e-8c11-7d02-b1f3-2f5f0a3c9d11"
RESULT = "01a1fd7f-02aa-7e53-9a44-6d1c1b1f4e20"
PROJECT = "gait"
MOTION_NAME = "left-leg-flexion"
CURSOR = "WyJ3YWxrIiwxN10"
ADDRESS = "/mcml/motion/frame[100]/frame_bone[3]/@Rx"
QUERY = f"//frame[motion_name='{MOTION_NAME}']"
TIME = "2026-01-31T14:02:11.120Z"

PROPERTY = {"name": "age", "value": "23", "unit": "year"}
LABEL_REQUEST = {"name": MOTION_NAME, "first": 100, "last": 142}
LABEL = {"id": 12, **LABEL_REQUEST, "rank": 0}
SUMMARY = {
    "id": DOCUMENT,
    "name": "walk",
    "project": PROJECT,
    "format": "bvh",
    "frames": 1197,
    "seconds_per_frame": 0.0083333,
    "duration": 9.9749601,
    "skeleton": 3,
    "revision": 1,
    "created": TIME,
    "modified": TIME,
}
RECEIPT = {
    "format": "bvh",
    "frames": 1197,
    "joints": 2,
    "channels": 9,
    "naming": {
        "rig": "person",
        "mapped": {"Hips": "Root"},
        "joints": [{"source": "Hips", "name": "Root", "confidence": 0.98, "how": "word"}],
        "unmapped": [{"source": "Ponytail", "name": "Ponytail", "why": "not recognised"}],
    },
    "unit": {"value": None, "stated": False, "why": "the file names no unit; the rest pose is 26.25 tall"},
    "frame_rate": {
        "seconds": 0.0083333,
        "frames_per_second": 120.00048,
        "stated": True,
        "why": "Frame time as the file writes it",
    },
    "up_axis": {"value": None, "stated": False, "why": "the file names no up axis; the rest pose is longest along Y"},
    "rotation_orders": {"ZXY": 2},
    "conventions": ["listed"],
    "translation": ["absolute"],
    "encoding": {"bvh": "utf-8"},
    "number_style": "fixed:4",
    "markers": False,
    "notices": [{"kind": "repair", "what": "the last line has no line feed", "at": "walk.bvh, line 1214"}],
    "twins": [],
}
BONE = {
    "name": "Root",
    "source_name": "Hips",
    "parent": None,
    "mapped": True,
    "channels": ["Tx", "Ty", "Tz", "Rz", "Rx", "Ry"],
    "rotation_order": "ZXY",
    "convention": "listed",
}
SPINE = {
    "name": "Spine",
    "source_name": "Spine",
    "parent": "Root",
    "mapped": False,
    "channels": ["Rz", "Rx", "Ry"],
    "rotation_order": "ZXY",
    "convention": "listed",
}
HASH = "0d7c84a04ddc5d9e723c0c553b3a9dceca7ba8fb63ee8dfabbad7dd182f5ee37"
DETAIL = {
    **SUMMARY,
    "description": "A walk on flat ground.",
    "properties": [PROPERTY],
    "unit": "cm",
    "up": "Y",
    "header": {"filename": "walk.bvh", "calibration_unit": "cm", "global_axis_of_gravity": "Y"},
    "bones": [BONE, SPINE],
    "labels": [LABEL],
    "files": [{"part": "bvh", "name": "walk.bvh", "bytes": 91342, "sha256": HASH}],
    "original": False,
    "receipt": RECEIPT,
    "links": {"self": f"/api/v1/documents/{DOCUMENT}", "mcml": f"/api/v1/documents/{DOCUMENT}/mcml"},
}
PROBLEM = {
    "type": "/docs/problems#format-error",
    "title": "Format error",
    "status": 422,
    "detail": "CHANNELS announces 6 names, 5 follow.",
    "where": {"file": "walk.bvh", "line": 4},
    "remedy": "Add the missing channel name.",
}
NODE = {"kind": "attribute", "document": DOCUMENT, "revision": 1, "address": ADDRESS, "value": "45.1942"}
FRAME_BONE = '<frame_bone name="left_up_leg" Rz="1.956" Rx="45.1942" Ry="-1.0556"/>'
MCML = f"""<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE mcml SYSTEM "mcml.dtd">
<mcml version="1.0"><header><filename>walk.bvh</filename></header>
<skeleton><bone><name>left_up_leg</name><order>Rz Rx Ry</order></bone></skeleton>
<motion><frames>1</frames><frametime>0.0083333</frametime>
<frame id="1"><motion_name>{MOTION_NAME}</motion_name>{FRAME_BONE}</frame></motion></mcml>
"""
RESULTS = f"""<?xml version="1.0" encoding="UTF-8"?>
<results>
<result document="{DOCUMENT}" revision="1" address="/mcml/motion/frame[100]/frame_bone[3]">{FRAME_BONE}</result>
</results>
"""


def shown(*examples: Any) -> dict[str, Any]:
    """The part of a model's JSON schema that shows examples of it."""
    return {"examples": list(examples)}


def example_of(model: type[BaseModel]) -> Any:
    """The first example that a model shows, {} where it shows none."""
    extra: Any = model.model_config.get("json_schema_extra") or {}
    return extra.get("examples", [{}])[0]
