"""One reader for all XML: what it finds, and what it refuses."""

from __future__ import annotations

import pytest

from goalwire import xml_tree


def test_elements_have_attributes_children_text_and_lines() -> None:
    root = xml_tree.read('<a b="1">\n  <c>one &amp;\n two</c>\n  <c/><d e="&lt;"/>\n</a>')
    assert (root.tag, root.attributes, root.line, root.text_line) == ('a', {'b': '1'}, 1, None)
    assert [(child.tag, child.line) for child in root.children] == [('c', 2), ('c', 4), ('d', 4)]
    assert (root.children[0].text, root.children[0].text_line) == ('one &\n two', 2)
    assert root.find('d') is root.children[2]
    assert root.find('e') is None
    assert len(root.findall('c')) == 2
    assert [element.tag for element in root.walk()] == ['a', 'c', 'c', 'd']


@pytest.mark.parametrize(
    ('data', 'problem', 'line'),
    [
        (b'', 'no element found', 1),
        (b'<a>\n<b></a>', 'mismatched tag', 2),
        (b'<a/><b/>', 'junk after document element', 1),
        (b'\n<!DOCTYPE a>\n<a/>', 'document type', 2),
        (b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', 'document type', 1),
        (b'<!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', 'document type', 1),
        (b'<a>&b;</a>', 'undefined entity', 1),
        (b'<?xml version="1.0" encoding="rot13"?><a/>', 'encoding', 1),
        (b'<a>' * 100_000, 'in one another', 1),
    ],
    ids=lambda given: str(given)[:24],
)
def test_what_is_no_xml_or_not_safe_is_refused_with_its_line(data: bytes, problem: str, line: int) -> None:
    with pytest.raises(xml_tree.XmlError, match=problem) as caught:
        xml_tree.read(data)
    assert caught.value.line == line


def test_a_text_of_many_lines_is_read_in_one_pass() -> None:
    lines = 'one\n' * 500_000
    assert xml_tree.read(f'<a>{lines}</a>').text == lines


def test_the_memory_of_many_small_elements_is_limited_where_one_asks_for_it() -> None:
    for many in ('<b/>', '<b c="" d=""/>', 'one\n'):
        data = f'<a>\n{many * 20_000}</a>'
        assert xml_tree.read(data, most_memory=64 << 20).tag == 'a'
        with pytest.raises(xml_tree.XmlError, match='more than 1 MB of memory'):
            xml_tree.read(data, most_memory=1 << 20)
