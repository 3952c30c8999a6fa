"""A node's table of parameters: the values that it keeps, and the changes that it tells."""

from __future__ import annotations

from typing import Any

import pytest

from goalwire.rules.parameters import Descriptor, Parameter, ParameterTable, Type


@pytest.fixture
def table() -> ParameterTable:
    table = ParameterTable({})
    declare(table, 'i', 1)
    declare(table, 'd', 1.5)
    return table


def declare(table: ParameterTable, name: str, value: Any, **kind: Any) -> tuple[list[str], ...]:
    kind.setdefault('type', Type.from_parameter_value(value))
    descriptor = Descriptor(name, **kind)
    return names(table.store([Parameter(name, value=value)], {name: descriptor}))


def names(changes: Any) -> tuple[list[str], ...]:
    kinds = changes.new, changes.changed, changes.deleted
    return tuple([parameter.name for parameter in kind] for kind in kinds)


def test_what_is_new_and_what_changes_is_told_apart(table: ParameterTable) -> None:
    assert declare(table, 'n', None, type=Type.INTEGER) == (['n'], [], [])
    several = [Parameter('n', value=1), Parameter('i', value=2), Parameter('n', value=3)]
    assert names(table.store(several)) == (['n'], ['i', 'n'], [])
    assert [parameter.value for parameter in table.values()] == [2, 1.5, 3]


def test_a_parameter_without_a_value_goes_and_frees_its_name(table: ParameterTable) -> None:
    declare(table, 'dyn', 1, dynamic_typing=True)
    assert names(table.store([Parameter('dyn')])) == ([], [], ['dyn'])
    assert 'dyn' not in table
    assert names(table.store([Parameter('dyn')])) == ([], [], [])
    assert not table.store([Parameter('dyn')])


def test_an_undeclared_parameter_comes_with_a_type_that_may_change(table: ParameterTable) -> None:
    table.store([Parameter('u', value=1)])
    assert table.judge([Parameter('u', value='text')]).successful
    table.store([Parameter('u', value='text')])
    descriptor = table.descriptor('u')
    assert descriptor is not None
    assert (descriptor.dynamic_typing, descriptor.type) == (True, Type.STRING)


def test_one_refusal_refuses_all(table: ParameterTable) -> None:
    outcome = table.judge([Parameter('d', value=2.5), Parameter('i', value='x')])
    assert outcome == (False, "Wrong parameter type, expected 'Type.INTEGER' got 'Type.STRING'")


def test_read_only_comes_before_every_other_reason(table: ParameterTable) -> None:
    declare(table, 'ro', 1, read_only=True)
    for value in (2, 'x', None):
        assert table.judge([Parameter('ro', value=value)]).reason == (
            'Trying to set a read-only parameter: ro.'
        )


def test_a_new_descriptor_keeps_the_name(table: ParameterTable) -> None:
    table.describe(Descriptor('other', Type.STRING), Parameter('i', value='s'))
    descriptor, parameter = table.descriptor('i'), table.get('i')
    assert descriptor == Descriptor('i', Type.STRING)
    assert parameter is not None
    assert parameter.value == 's'


def test_a_value_that_is_still_missing_is_known_from_one_that_may_be(table: ParameterTable) -> None:
    declare(table, 'typed', None, type=Type.INTEGER)
    declare(table, 'dynamic', None, dynamic_typing=True)
    missing = [parameter.name for parameter in table.values() if table.is_uninitialized(parameter)]
    assert missing == ['typed']


def test_a_table_is_a_mapping_that_may_change_while_it_is_gone_through(table: ParameterTable) -> None:
    for name, parameter in table.items():
        assert table.get(name) is parameter
        table.undeclare(name)
    assert (dict(table), len(table), table.get('first')) == ({}, 0, None)
