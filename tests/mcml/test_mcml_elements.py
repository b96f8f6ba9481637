"""Heads survive as elements, hand-written documents get sensible defaults, nonsense is refused with its address."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcml.errors import DocumentError
from mcml.language import dtd
from mcml.language.element import Element, leaf
from mcml.language.elements import addresses, check_counts, from_head, refresh_counts, to_head
from mcml.language.lexical import escape, is_decimal, join_list, split_list, unescape
from mcml.language.writer import write_element
from mcml.motion.clip import ClipHead
from mcml.motion.skeleton import Convention
from tests.mcml.strategies import HARD_TEXTS, heads


@given(heads())
def test_a_head_survives_as_elements(head: ClipHead) -> None:
    assert to_head(from_head(head), head.frame_time) == head


@given(heads())
def test_elements_of_a_head_are_valid_and_survive_as_xml(head: ClipHead) -> None:
    document = from_head(head)
    dtd.validate_frames(document, ())
    document.children.append(Element("motion", children=[leaf("frames", "0")]))
    parsed = etree.fromstring(write_element(document))
    assert to_head(_element(parsed), head.frame_time) == head


def _element(node: etree._Element) -> Element:
    return Element(str(node.tag), dict(node.attrib), (node.text or ""), [_element(child) for child in node])


@given(HARD_TEXTS)
def test_escaped_text_survives_xml_and_trimming(text: str) -> None:
    xml = write_element(leaf("name", escape(text), source_name=escape(text)))
    node = etree.fromstring(xml)
    assert unescape((node.text or "").strip(" \t\r\n")) == text
    assert unescape(node.get("source_name", "")) == text


@given(st.lists(HARD_TEXTS))
def test_lists_survive(items: list[str]) -> None:
    assert split_list(join_list(items)) == tuple(items)


@pytest.mark.parametrize("text", ["1", "-1.5", ".5", "+1.", "4.48953e-011", "-0"])
def test_decimals(text: str) -> None:
    assert is_decimal(text)


@pytest.mark.parametrize("text", ["", "nan", "inf", "1e999", "1_0", " 1", "1,5", "0x1", "١", "1e", "--1", "1\n"])
def test_not_decimals(text: str) -> None:
    assert not is_decimal(text)


FIGURE_2 = """<mcml version="1.0"><header/>
<root order="Tx Ty Tz Rx Ry Rz" axis="XYZ" position="0 0 0" orientation="0 0 0"/>
<skeleton><bone id="1"><name> l femur </name><direction> 0.34202 0.939693 0 </direction><length> 6.8845 </length>
<axis> 0 0 20 XYZ </axis><dof> rx ry rz </dof><limits> -160.0 20.0 </limits><bone id="2"><name> l tibia </name></bone>
</bone></skeleton></mcml>"""


def test_the_paper_s_figure_2_reads_as_an_asf_skeleton() -> None:
    head = to_head(_element(etree.fromstring(FIGURE_2)))
    root, femur, tibia = head.skeleton.joints
    assert (root.name, root.channels, root.rotation_order) == ("Root", ("Tx", "Ty", "Tz", "Rx", "Ry", "Rz"), "XYZ")
    assert root.convention is femur.convention is tibia.convention is Convention.FIXED
    assert (femur.name, femur.channels, femur.axis, femur.axis_order, femur.length, femur.id) == (
        "l femur", ("Rx", "Ry", "Rz"), ("0", "0", "20"), "XYZ", "6.8845", "1",
    )  # fmt: skip
    assert [joint.parent for joint in head.skeleton.joints] == [-1, 0, 1]
    assert tibia.channels == ()


@pytest.mark.parametrize(
    ("body", "address"),
    [
        ("<bone><name>a</name><length>long</length></bone>", "/mcml/skeleton/bone/length"),
        ("<bone><name>a</name></bone><bone><name>b</name><position>1 2</position></bone>",
         "/mcml/skeleton/bone[2]/position"),
        ("<bone><name>a</name><axis>1 2 XYZ</axis></bone>", "/mcml/skeleton/bone/axis"),
        ("<bone><name>a</name><order>Rx Wx</order></bone>", "/mcml/skeleton/bone/order"),
        ("<bone><name>a</name><dof>rx rx</dof></bone>", "/mcml/skeleton/bone/dof"),
        ("<bone><name/></bone>", "/mcml/skeleton/bone"),
        ("<bone declared='x'><name>a</name></bone>", "/mcml/skeleton/bone/@declared"),
        ("<bone><name>a</name><end_site position='0 0'/></bone>", "/mcml/skeleton/bone/end_site[1]/@position"),
        ("<bone><name>a</name></bone><bone><name>a</name></bone>", "/mcml/skeleton"),
    ],
)  # fmt: skip
def test_nonsense_is_refused_where_it_stands(body: str, address: str) -> None:
    xml = f"<mcml version='1.0'><header/><skeleton>{body}</skeleton></mcml>"
    with pytest.raises(DocumentError) as caught:
        to_head(_element(etree.fromstring(xml)))
    assert caught.value.at is not None
    assert caught.value.at.element == address


@given(heads())
def test_every_address_is_an_xpath_that_finds_its_element(head: ClipHead) -> None:
    document = from_head(head)
    tree = etree.fromstring(write_element(document)).getroottree()
    for address, element in addresses(document):
        found = tree.xpath(address)
        assert [node.tag for node in found] == [element.tag]
        assert len(found) == 1


def test_counts_are_checked_and_refreshed() -> None:
    header = Element("header", children=[leaf("num_segments", "9"), leaf("num_frames", "5")])
    document = Element(
        "mcml", children=[header, Element("skeleton", children=[Element("bone", children=[leaf("name", "a")])])]
    )
    with pytest.raises(DocumentError, match="num_segments says '9', the document has 1"):
        check_counts(document, 5)
    fresh = refresh_counts(document, 7)
    check_counts(fresh, 7)
    with pytest.raises(DocumentError, match="num_frames says '7', the document has 8"):
        check_counts(fresh, 8)
    assert header.leaf("num_frames") == "5"
