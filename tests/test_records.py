"""Records behave as frozen dataclasses with slots do."""

from __future__ import annotations

import copy
import dataclasses
import pickle
import pprint
from dataclasses import dataclass
from typing import Any

import pytest
from helpers.fresh import output_of

from goalwire.records import record, replace


@record
class Point:
    """A place."""

    x: float
    y: float = 0.0

    @property
    def is_origin(self) -> bool:
        return not self.x and not self.y


@record
class Named:
    name: str


@record
class Noted:
    name: str
    note: str = ''

    COMPARE_EXCLUDE = ('note',)


@dataclass(frozen=True, slots=True)
class Twin:
    x: float
    y: float = 0.0


def test_fields_come_by_position_by_name_and_by_default() -> None:
    assert (Point(1).x, Point(1).y) == (1, 0.0)
    assert Point(1, 2) == Point(y=2, x=1)


@pytest.mark.parametrize('arguments', [{}, {'x': 1, 'z': 2}])
def test_a_missing_or_unknown_field_is_an_error_as_of_any_function(arguments: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match=r'Point.__init__\(\)'):
        Point(**arguments)


def test_nothing_can_be_set_added_or_deleted() -> None:
    point: Any = Point(1)
    with pytest.raises(AttributeError, match='Point is immutable'):
        point.x = 2
    with pytest.raises(AttributeError, match='Point is immutable'):
        del point.x
    with pytest.raises(AttributeError, match='Point is immutable'):
        point.z = 3
    assert point == Point(1)
    assert not hasattr(point, '__dict__')


def test_records_are_equal_to_their_own_kind_alone() -> None:
    others: list[object] = [Point(1, 3), Twin(1, 2), (1, 2)]
    assert Point(1, 2) == Point(1, 2)
    assert Point(1, 2) not in others
    assert {Point(1, 2): 'found'}[Point(1, 2)] == 'found'


def test_they_hash_and_show_as_dataclasses_do() -> None:
    assert hash(Point(1, 2)) == hash(Twin(1, 2))
    assert repr(Point(1, 2)) == repr(Twin(1, 2)).replace('Twin', 'Point')
    assert repr(Named('a')) == "Named(name='a')"


def test_a_field_set_aside_is_kept_but_not_compared() -> None:
    assert Noted('a', 'first') == Noted('a', 'second')
    assert hash(Noted('a', 'first')) == hash(Noted('a'))
    assert Noted('a', 'first').note == 'first'


@pytest.mark.parametrize('made', [Point(1, 2), Named('a'), Noted('a', 'b')])
def test_they_can_be_copied_and_pickled(made: object) -> None:
    assert copy.copy(made) == copy.deepcopy(made) == pickle.loads(pickle.dumps(made)) == made


def test_replace_changes_some_fields_of_a_copy() -> None:
    point = Point(1, 2)
    assert replace(point, y=3) == Point(1, 3)
    assert point == Point(1, 2)
    with pytest.raises(TypeError, match='z'):
        replace(point, z=1)


def test_properties_docstrings_and_matching_work() -> None:
    assert Point(0).is_origin
    assert Point.__doc__ == 'A place.'
    match Point(1, 2):
        case Point(x, y):
            assert (x, y) == (1, 2)


def test_neither_goalwire_nor_a_node_imports_what_dataclasses_need(tmp_path: Any) -> None:
    program = """
        import sys, rclpy
        from std_srvs.srv import Empty
        rclpy.init()
        rclpy.create_node('a').create_client(Empty, 'b')
        print(sorted({'dataclasses', 'inspect', 'ast'} & set(sys.modules)))
        """
    assert output_of(program, cwd=tmp_path, RMW_IMPLEMENTATION='goalwire_memory') == '[]'


@record
class Share:
    part: float

    def __post_init__(self) -> None:
        if not 0 <= self.part <= 1:
            raise ValueError(f'a share is from 0 to 1, not {self.part}')

    def __repr__(self) -> str:
        return f'<{self.part:.0%}>'


def test_a_record_may_refuse_values_and_show_itself() -> None:
    assert repr(Share(0.5)) == '<50%>'
    with pytest.raises(ValueError, match='from 0 to 1'):
        Share(2)


def test_the_functions_of_dataclasses_take_records() -> None:
    point = Point(1.0)
    assert dataclasses.is_dataclass(point)
    assert dataclasses.replace(point, y=2.0) == Point(1.0, 2.0)
    assert dataclasses.asdict(point) == {'x': 1.0, 'y': 0.0}
    assert [field.name for field in dataclasses.fields(point)] == ['x', 'y']
    assert pprint.pformat(point) == repr(point)
