"""Reading JSON5, with eclipse-zenoh's reader beside ours."""

from __future__ import annotations

import json
from contextlib import suppress

import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from goalwire.transport.zenoh.settings.json5 import DEEPEST, Json5Error, read
from goalwire.transport.zenoh.settings.values import Json

GOOD = [
    '{}',
    '[]',
    '{a: 1, "b": 2, \'c\': 3, $d_1: 4, é: 5,}',
    '[1, 2, 3,]',
    '// a remark\n{ /* and\n another */ a: 1 } // and one more',
    '"it\'s"',
    '\'say "so"\'',
    r'"line\nend \t \\ \" \u00e9 \x41 \/ \q"',
    '"one \\\nline"',
    '{a: {b: [{c: null}, true, false]}}',
    '[0, -0, 17, +17, 0x1F, .5, 5., 1e3, 1.5e-2, -2.5E+2]',
    '{true: 1, null: 2, Infinity: 3}',
]


@pytest.mark.parametrize('text', GOOD)
def test_what_zenoh_reads_is_read_the_same(text: str) -> None:
    theirs = zenoh.Config()
    theirs.insert_json5('metadata', text)
    assert read(text).value == json.loads(theirs.get_json('metadata'))


@pytest.mark.parametrize(
    ('text', 'value'),
    [
        ('\ufeff{a: 1}', {'a': 1}),
        ('{a\u00a0:\u20281}', {'a': 1}),
        (r'"\ud83e\udd16"', '\U0001f916'),
        ('[Infinity, -Infinity]', [float('inf'), float('-inf')]),
        ('-0xff', -255),
        ('9' * 5000, float('inf')),
    ],
)
def test_and_some_that_it_does_not(text: str, value: Json) -> None:
    assert read(text).value == value


values: st.SearchStrategy[Json] = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)


@given(values)
def test_all_json_is_json5(value: Json) -> None:
    assert read(json.dumps(value)).value == value
    assert read(json.dumps(value, ensure_ascii=False, indent=1)).value == value


@given(st.text(alphabet='{}[]:,"\'\\/*\n ax0.-+eu$', max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    with suppress(Json5Error):
        read(text)


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', 'line 1, column 1: a value is expected, but the text ends'),
        (
            '{\n  mode: "peer",\n  connect: {\n',
            "line 4, column 1: a name or '}' is expected, but the text ends",
        ),
        ('{mode: peer}', "line 1, column 8: a value is expected, not 'peer'"),
        ('{mode "peer"}', "line 1, column 7: ':' after 'mode' is expected, not '\"peer\"'"),
        ('{a: 1\n b: 2}', "line 2, column 2: ',' or '}' is expected, not 'b'"),
        ('[1 2]', "line 1, column 4: ',' or ']' is expected, not '2'"),
        ('{a: 1, a: 2}', "line 1, column 8: 'a' is there twice"),
        ('{} {}', "line 1, column 4: the end of the text is expected, not '{'"),
        ('"abc\n"', 'line 1, column 1: a text that begins with " has no end on its line'),
        ('1 /* on', "line 1, column 3: a comment '/*' has no end"),
        ('{a: #}', "line 1, column 5: '#' cannot be read here"),
        (r'"\u12"', "'\\u' is not an escape"),
        (r'"\ud83e"', 'a text holds half a character'),
        ('[' * (DEEPEST + 1), f'more than {DEEPEST} objects and lists lie within each other'),
        ('012', "'0' cannot be read here"),
        ('{"a": -}', "'-' cannot be read here"),
    ],
)
def test_a_mistake_is_told_with_its_place(text: str, said: str) -> None:
    with pytest.raises(Json5Error) as caught:
        read(text)
    assert said in str(caught.value)


def test_each_value_is_known_by_its_line() -> None:
    lines = read('{\n  mode: "peer",\n  connect: {\n    endpoints: [\n      "x"],\n  },\n}').lines
    assert lines == {'mode': 2, 'connect': 3, 'connect/endpoints': 4}
