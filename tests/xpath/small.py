"""The document that the XPath cases are asked, and libxml2's answers to compare with."""

from __future__ import annotations

import copy
from typing import Any

from lxml import etree

from mcml_service.xpath.language.reach import Projection
from mcml_service.xpath.trees.evaluate import Addresses
from tests.xpath.libxml2 import describe

DOCUMENT = (
    '<mcml version="1.0"><header format="bvh"><filename>reach.bvh</filename><num_frames>6</num_frames>'
    '<property name="age" value="23" unit="year"/><comment>one</comment><comment>two</comment></header>'
    '<root name="hips" order="Tx Ty Tz Rz" position="0 0 0"/><skeleton>'
    '<bone source_name="LeftArm" mapped="true"><name>left_up_arm</name><position>1 2 3</position>'
    '<order>Rz Rx Ry</order><bone mapped="false"><name>tail</name><length>1.5</length><end_site position="0 1 0"/>'
    '</bone></bone><bone mapped="true"><name>left_up_leg</name><length>2</length></bone></skeleton>'
    "<motion><frames>6</frames><frametime>0.0333</frametime>"
    '<frame id="1"><motion_name>walk</motion_name><frame_bone name="hips" Tx="1.0" Ty="2.0"/>'
    '<frame_bone name="left_up_arm" Rx="10.0"/></frame>'
    '<frame id="2"><motion_name>walk</motion_name><motion_name>bar-1</motion_name><frame_bone name="hips" Tx="1.5"/>'
    '<frame_bone name="left_up_arm" Rx="20.5" Ry="-0.0"/></frame>'
    '<frame id="3"><motion_name>left-arm-abduction</motion_name><motion_name>bar-1</motion_name>'
    '<frame_bone name="left_up_arm" Rx="-3.25"/><frame_bone name="tail"/></frame>'
    '<frame id="4"/>'
    '<frame id="5"><motion_name>walk</motion_name></frame>'
    '<frame id="6"><frame_bone name="hips" Tx="9.0"/></frame>'
    "</motion></mcml>"
)


def tree() -> Any:
    """The document, parsed by libxml2."""
    return etree.fromstring(DOCUMENT).getroottree()


def projected(level: Projection) -> Any:
    """The document without what the projection leaves out."""
    small = copy.deepcopy(tree())
    drop = {Projection.HEAD: "//frame", Projection.FRAMES: "//frame_bone", Projection.WHOLE: "/.."}[level]
    for node in small.xpath(drop):
        node.getparent().remove(node)
    return small


def answer(document: Any, expression: str) -> Any:
    """libxml2's answer: a scalar, or (address, value) of each node. Document nodes are left out, as lxml does."""
    value = document.xpath(expression)
    if not isinstance(value, list):
        return value
    addresses = Addresses()
    return [tuple(describe(node, addresses)[1:]) for node in value]
