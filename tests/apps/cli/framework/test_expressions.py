"""The results of `--filter`: they come soon, and errors name the part of the expression."""

from __future__ import annotations

from time import monotonic

import pytest
from geometry_msgs.msg import PoseWithCovariance
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8MultiArray

from goalwire.apps.cli.framework.expressions import Expression
from goalwire.apps.cli.framework.outcome import CommandError, Outcome

JOINTS = JointState(name=['left', 'right'], position=[0.5, -2.0])


@pytest.mark.parametrize(
    ('text', 'holds'),
    [
        ('m.position[0] > 0.2', True),
        (' m.position[0] > 0.2', True),
        ('0 < m.position[0] < 0.2', False),
        ('"left" in m.name and not m.velocity', True),
        ('m.header.stamp.sec == 0', True),
        ('max(m.position) - min(m.position) >= 2.5', True),
        ('round(m.position[1] / 3, 2) == -0.67', True),
        ('len(m.name) if m.name else 0', True),
        ('sum(m.position) == -1.5 or 1 / 0', True),
        ('sorted(m.position)[0] == m.position[-1]', True),
        ('int("7") % 4 == 3 and str(3) == "3"', True),
        ('all([True, m.name[0:1] == ["left"]])', True),
    ],
)
def test_an_expression_is_worked_out(text: str, holds: bool) -> None:
    assert Expression(text)(JOINTS) is holds


def test_a_list_of_numbers_is_compared_item_by_item() -> None:
    pose = PoseWithCovariance()
    assert Expression('all(m.covariance == 0)')(pose)
    with pytest.raises(CommandError, match=r"is a list: write all\('m.covariance == 0'\)"):
        Expression('m.covariance == 0')(pose)


@pytest.mark.parametrize(
    ('text', 'problem'),
    [
        ('round(1, -999999999)', 'round takes from -400 to 400 digits, not -999999999'),
        ('round(m.position[0], 10**9)', "'10 ** 9' is not allowed here"),
        ("'9' * 9999999999", 'only numbers are multiplied'),
        ("'%9999999999d' % 1", 'only numbers are multiplied'),
        ('[1] * 9999999999', 'only numbers are multiplied'),
        ('2 ** 2 ** 40', 'is not allowed here'),
        ('1 << 99999999999', 'is not allowed here'),
        ('sum(range(10 ** 12))', 'is not allowed here'),
        ('sum([[1], [2]], [])', 'sum takes only numbers'),
        ('[x for x in m.name]', 'is not allowed here'),
        ('m.name.join("ab")', 'is not allowed here'),
        ("'{:>9999999999}'.format(1)", 'is not allowed here'),
        ('m.__class__', 'is not allowed here'),
        ('+'.join(['1'] * 2000), 'it has 3999 characters, and may have 2000'),
        ('(' * 900 + '1' + ')' * 900, 'nested'),
        ('-' * 1999 + '1', 'nested too deeply'),
        ('m.name <', 'it is not a Python expression: '),
        ('1 / m.header.stamp.sec', "'1 / m.header.stamp.sec' divides by zero"),
        ('int(1e308 * 10)', "'int(1e+308 * 10)' is too large a number"),
        ('m.name[5]', "'m.name' has 2 items, and no item 5"),
        ('m.nme', "'m' has no field 'nme'; its fields are: header, name, position, velocity, effort"),
        ('m.name.first', "'m.name' is a list, which has no field 'first'"),
        ('m.name > 3', "'m.name > 3' cannot be evaluated with a list and a number"),
        ('m.header["stamp"]', 'cannot be evaluated with a message and a text'),
        ('int("x")', "'int('x')' cannot be evaluated with a text"),
        ('-m.header', "'-m.header' cannot be evaluated with a message"),
        ('3 in 4', "'3 in 4' cannot be evaluated with a number and a number"),
        ('max()', "'max()' cannot be evaluated with nothing"),
        ('max([])', "'max([])' cannot be evaluated with a list"),
    ],
)
def test_what_cannot_be_worked_out_is_refused_at_once(text: str, problem: str) -> None:
    began = monotonic()
    with pytest.raises(CommandError) as caught:
        Expression(text)(JOINTS)
    assert monotonic() - began < 5
    assert caught.value.outcome is Outcome.BAD_VALUE
    assert problem in str(caught.value)


def test_a_long_list_is_visited_so_often_and_no_more() -> None:
    image = UInt8MultiArray(data=bytes(1_000_000))
    assert Expression('sum(m.data) == 0 and max(m.data) == 0')(image)
    with pytest.raises(CommandError, match='it visits more than 20,000,000 items'):
        Expression('len(' + ' + '.join(['m.data'] * 20) + ')')(image)
    with pytest.raises(CommandError, match='it visits more than 20,000,000 items'):
        Expression('len([' + ', '.join(['str(m)'] * 25) + '])')(image)
