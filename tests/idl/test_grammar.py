"""The grammar of .msg, .srv and .action: every feature, every refusal with its file, line and character."""

from __future__ import annotations

import time

import pytest

from goalwire.errors import InterfaceSyntaxError
from goalwire.idl.grammar import parse_action, parse_message, parse_service
from goalwire.idl.model import Constant, Field, FieldType, Shape


def parse_field(line: str) -> Field:
    (field,) = parse_message(line, 'demo_msgs', 'Demo').fields
    return field


def parse_constant(line: str) -> Constant:
    (constant,) = parse_message(line, 'demo_msgs', 'Demo').constants
    return constant


@pytest.mark.parametrize(
    ('text', 'expected'),
    [
        ('bool', FieldType('bool')),
        ('byte', FieldType('byte')),
        ('char', FieldType('char')),
        ('uint64', FieldType('uint64')),
        ('float32', FieldType('float32')),
        ('wstring', FieldType('wstring')),
        ('string<=22', FieldType('string', string_capacity=22)),
        ('wstring<=3[]', FieldType('wstring', Shape.UNBOUNDED, string_capacity=3)),
        ('int32[5]', FieldType('int32', Shape.ARRAY, 5)),
        ('int32[<=5]', FieldType('int32', Shape.BOUNDED, 5)),
        ('int32[]', FieldType('int32', Shape.UNBOUNDED)),
        ('string<=10[<=5]', FieldType('string', Shape.BOUNDED, 5, 10)),
        ('Other', FieldType('demo_msgs/msg/Other')),
        ('Other[2]', FieldType('demo_msgs/msg/Other', Shape.ARRAY, 2)),
        ('geometry_msgs/Point', FieldType('geometry_msgs/msg/Point')),
        ('geometry_msgs/msg/Point[]', FieldType('geometry_msgs/msg/Point', Shape.UNBOUNDED)),
    ],
)
def test_a_type_is_understood(text: str, expected: FieldType) -> None:
    assert parse_field(f'{text} value').type == expected


@pytest.mark.parametrize(
    ('line', 'expected'),
    [
        ('bool b true', True),
        ('bool b 0', False),
        ('byte b 7', b'\x07'),
        ('int8 i -128', -128),
        ('uint16 i 0xff', 255),
        ('int32 i 007', 7),
        ('float64 f -1.5e3', -1500.0),
        ('float32 f 3', 3.0),
        ('string s hello world', 'hello world'),
        ('string s "  spaces  "', '  spaces  '),
        ("string s 'it''s'", None),
        ('string s "say \\"hi\\""', 'say "hi"'),
        ('string s \'say "hi"\'', 'say "hi"'),
        ('string s "a\\tb\\x41\\101"', 'a\tbAA'),
        ('wstring s "ハロー"', 'ハロー'),
        ('string s "a # b = c"  # a comment', 'a # b = c'),
        ('string s ""', ''),
        ('int32[] i [1, 2,3]', (1, 2, 3)),
        ('int32[] i []', ()),
        ('string[2] s ["a, b", c]', ('a, b', 'c')),
        ('float64[<=3] f [0.5]', (0.5,)),
    ],
)
def test_a_default_is_understood(line: str, expected: object) -> None:
    if expected is None:
        with pytest.raises(InterfaceSyntaxError, match='quotes'):
            parse_field(line)
    else:
        assert parse_field(line).default == expected


@pytest.mark.parametrize(
    ('line', 'expected'),
    [
        ('int32 X=5', Constant('X', 'int32', 5)),
        ('int32 FIVE_HUNDRED = 500 # why not', Constant('FIVE_HUNDRED', 'int32', 500, 'why not')),
        ('byte ERROR=2', Constant('ERROR', 'byte', b'\x02')),
        ('char LETTER=65', Constant('LETTER', 'char', 65)),
        ('string NAME=plain text', Constant('NAME', 'string', 'plain text')),
        ('string EMPTY=', Constant('EMPTY', 'string', '')),
        ("string QUOTED='a=b # c'", Constant('QUOTED', 'string', 'a=b # c')),
        ('bool YES=True', Constant('YES', 'bool', True)),
        ('float32 PI=3.14', Constant('PI', 'float32', 3.14)),
    ],
)
def test_a_constant_is_understood(line: str, expected: Constant) -> None:
    assert parse_constant(line) == expected


def test_comments_stay_with_what_they_speak_of() -> None:
    message = parse_message(
        '# A joint.\n'
        '# Two lines.\n'
        '\n'
        '# lone remark\n'
        '\n'
        '# before\n'
        'float64 speed  # how fast [rad/s]\n'
        '               # and on\n'
        'int32 count\n',
        'demo_msgs',
        'Joint',
    )
    assert message.comment == 'A joint.\nTwo lines.\n\nlone remark'
    speed, count = message.fields
    assert speed.comment == 'before\nhow fast [rad/s]\nand on'
    assert speed.unit == 'rad/s'
    assert (count.comment, count.unit, count.line) == ('', '', 9)


@pytest.mark.parametrize(
    ('comment', 'unit'), [('in [m]', 'm'), ('[0, 1]', ''), ('[1..5] in [m/s^2]', 'm/s^2'), ('', '')]
)
def test_the_unit_is_what_stands_in_square_brackets(comment: str, unit: str) -> None:
    assert parse_field(f'float64 x # {comment}').unit == unit


def test_tabs_carriage_returns_and_a_missing_last_newline_do_no_harm() -> None:
    message = parse_message('int32\ta\r\n  float64   b\t1.0\r\nint8 C\t=\t3', 'demo_msgs', 'Demo')
    assert [field.name for field in message.fields] == ['a', 'b']
    assert message.constants == (Constant('C', 'int8', 3),)


def test_a_service_has_request_response_and_event() -> None:
    service = parse_service('int64 a\n---\nint64 sum\n', 'demo_msgs', 'Add')
    assert [message.name for message in service.messages] == ['Add_Request', 'Add_Response', 'Add_Event']
    assert [(field.name, field.type) for field in service.event.fields] == [
        ('info', FieldType('service_msgs/msg/ServiceEventInfo')),
        ('request', FieldType('demo_msgs/srv/Add_Request', Shape.BOUNDED, 1)),
        ('response', FieldType('demo_msgs/srv/Add_Response', Shape.BOUNDED, 1)),
    ]


def test_an_action_has_all_its_derived_types() -> None:
    action = parse_action('int32 order\n---\nint32[] sequence\n---\nint32 last\n', 'demo_msgs', 'Count')
    assert sorted(message.full_name for message in action.messages) == [
        f'demo_msgs/action/Count_{suffix}'
        for suffix in (
            'Feedback', 'FeedbackMessage', 'GetResult_Event', 'GetResult_Request', 'GetResult_Response',
            'Goal', 'Result', 'SendGoal_Event', 'SendGoal_Request', 'SendGoal_Response',
        )
    ]  # fmt: skip
    assert [field.name for field in action.feedback_message.fields] == ['goal_id', 'feedback']
    assert [field.name for field in action.get_result.response.fields] == ['status', 'result']


def test_empty_parts_of_services_and_actions_are_fine() -> None:
    assert parse_service('---', 'demo_msgs', 'Ping').request.fields == ()
    assert parse_action('---\n---\n', 'demo_msgs', 'Wait').feedback.fields == ()


@pytest.mark.parametrize(
    ('text', 'line', 'column', 'problem'),
    [
        ('int32 a\nint32', 2, 1, "'int32' has no name after it"),
        (' WORD = 1', 1, 2, "'WORD = 1' has no name"),
        ('int32 a\n\nint b', 3, 1, "'int' is not a type .write int32."),
        ('Header header', None, None, None),
        ('time stamp', 1, 1, "'time' is not a type .write builtin_interfaces/Time."),
        ('geometry_msgs/srv/Point p', 1, 1, 'is not a type'),
        ('Geometry/Point p', 1, 1, 'is not a type'),
        ('../etc/Passwd p', 1, 1, 'is not a type'),
        ('int32 Bad', 1, 7, "'Bad' is not a field name"),
        ('int32 bad_', 1, 7, "'bad_' is not a field name"),
        ('int32 b__ad', 1, 7, 'is not a field name'),
        ('int32 2d', 1, 7, 'is not a field name'),
        ('int32 class', 1, 7, "'class' is taken by Python"),
        ('int32 check_fields', 1, 7, 'is taken by the generated class'),
        ('  int32 a\n  int32 a', 2, 9, "'a' is already defined in line 1"),
        ('int32 low=1', 1, 7, "'low' is not a constant name"),
        ('string a "\\0"', 1, 10, 'field a: a string cannot contain a NUL'),
        ('string A="\\x00"', 1, 10, 'constant A: a string cannot contain a NUL'),
        ('wstring a "\\ud800"', 1, 11, 'half of a surrogate pair is not a character'),
        ('int32 BAD_=1', 1, 7, "'BAD_' is not a constant name"),
        ('int32 B__AD=1', 1, 7, "'B__AD' is not a constant name"),
        (f'int32 {"A" * 4000}a=1', 1, 7, 'is not a constant name'),  # at once, not in 2**4000 steps
        ('int32[] X=1', 1, 1, 'only single values of primitive types'),
        ('Point X=1', 1, 1, 'only single values of primitive types'),
        ('int32 X=', 1, 9, 'constant X has no value'),
        ('int32 X=five', 1, 9, "'five' is not an integer"),
        ('uint8 X=256', 1, 9, 'outside the range of uint8, .0, 255.'),
        ('int8 x  -129', 1, 9, 'outside the range of int8'),
        ('bool b maybe', 1, 8, 'is not a bool'),
        ('float64 f fast', 1, 11, 'is not a number'),
        ('float32 f 1e39', 1, 11, 'outside the range of float32'),
        ('int32[3] i [1, 2]', 1, 12, 'has 2 values, the array exactly 3'),
        ('int32[<=1] i [1, 2]', 1, 14, 'has 2 values, the sequence at most 1'),
        ('int32[] i 1', 1, 11, 'the default of an array is written'),
        ('int32[] i [1,]', 1, 11, 'missing after the last comma'),
        ('Point p 1', 1, 9, 'cannot have a default'),
        ('string<=3 s "long"', 1, 13, 'has 4 characters, its type at most 3'),
        ('string s "open', 1, 10, 'quotes'),
        ('int32[0] i', 1, 7, 'is not a size'),
        ('int32[-1] i', 1, 7, 'is not a size'),
        ('int32[<=x] i', 1, 7, 'is not a size'),
        ('string<=0 s', 1, 9, 'is not a size'),
        ('int32<=3 i', 1, 1, 'only string and wstring can be bounded'),
        ('int32[2][3] i', 1, 1, 'is not a type'),
        ('int32 a ---', 1, 9, 'is not an integer'),
    ],
)
def test_a_malformed_line_is_refused_by_file_line_and_character(
    text: str, line: int | None, column: int | None, problem: str | None
) -> None:
    if problem is None:  # a relative name: whether it exists is the registry's question
        assert parse_field(text).type.base == 'demo_msgs/msg/Header'
        return
    with pytest.raises(InterfaceSyntaxError, match=problem) as caught:
        parse_message(text, 'demo_msgs', 'Demo', source='demo_msgs/msg/Demo.msg')
    assert (caught.value.line, caught.value.column) == (line, column)
    assert str(caught.value).startswith(f'demo_msgs/msg/Demo.msg:{line}:{column}: ')


@pytest.mark.parametrize(
    ('text', 'line'), [('int32 a\nint32 b', 2), ('---\nint32 a\n---\nint32 b', 3), ('', 1)]
)
def test_a_service_needs_exactly_one_separator(text: str, line: int) -> None:
    with pytest.raises(InterfaceSyntaxError, match=r"a .srv has 1: |Demo.srv has no line '---'") as caught:
        parse_service(text, 'demo_msgs', 'Demo')
    assert caught.value.line == line


def test_an_action_needs_two_separators() -> None:
    with pytest.raises(InterfaceSyntaxError, match=r'found 1 separator lines .*goal --- result --- feedback'):
        parse_action('int32 a\n---\nint32 b', 'demo_msgs', 'Demo')


def test_lines_count_through_the_parts_of_an_action() -> None:
    with pytest.raises(InterfaceSyntaxError) as caught:
        parse_action('int32 a\n---\nint32 b\n---\nint3 c', 'demo_msgs', 'Demo')
    assert caught.value.line == 5


@pytest.mark.parametrize(
    ('package', 'name'), [('Demo', 'Ok'), ('demo_msgs', 'low'), ('demo__msgs', 'Ok'), ('demo', 'A_B')]
)
def test_forbidden_names_are_refused(package: str, name: str) -> None:
    with pytest.raises(InterfaceSyntaxError, match=r'is not a (package|type) name'):
        parse_message('', package, name)


def test_a_misspelt_primitive_is_answered_with_the_nearest() -> None:
    with pytest.raises(InterfaceSyntaxError, match="'int33' is not a type; did you mean int32"):
        parse_message('int33 count', 'p', 'X')


@pytest.mark.parametrize(
    'line',
    [
        'int32 x ' + '9' * 5000,
        'int32 X=' + '9' * 5000,
        'int64 x 0x' + 'f' * 50_000,
        'int64 x -' + '1_' * 5000 + '1',
        'int32[' + '9' * 5000 + '] x',
        'int32[<=' + '9' * 5000 + '] x',
        'string<=' + '9' * 5000 + ' x',
        'float64 x ' + '9' * 5000,
        'float64 x 1e999',
        'float64[] x [0, -1e400]',
        'int32 ' + 'x' * 100_000 + '-',
        'x' * 500_000 + ' y',
        'int32 x' + ' ' * 500_000 + 'y',
        'string[] x [' + '"' * 100_001 + ']',
        'int32 \x1b[31mred',
    ],
    ids=lambda line: line[:12],
)
def test_a_line_of_any_length_is_refused_soon_and_in_a_short_text(line: str) -> None:
    started = time.process_time()
    with pytest.raises(InterfaceSyntaxError, match=r'demo_msgs/msg/It\.msg:1:\d+: ') as caught:
        parse_message(line, 'demo_msgs', 'It')
    assert time.process_time() - started < 5  # s; quadratic ones take minutes
    assert len(str(caught.value)) < 400
    assert str(caught.value).isprintable()


@pytest.mark.parametrize(
    'line',
    [
        'int32[] x [' + ','.join('1' * 200_000) + ']',
        'string[] x [' + ','.join(['"a,b"'] * 100_000) + ']',
        'string x "' + '#"' * 200_000,
        'int32' + ' ' * 500_000 + 'x',
        'int32 x #' + '[' * 300_000,
        'int32[007] x',
    ],
    ids=lambda line: line[:12],
)
def test_a_long_line_is_read_in_linear_time(line: str) -> None:
    started = time.process_time()
    assert parse_message(line, 'demo_msgs', 'It').fields[0].unit == ''
    assert time.process_time() - started < 8  # s; quadratic ones take minutes
