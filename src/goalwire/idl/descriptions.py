"""Turns a type description from another node into the text of a definition (REP 2016).

`~/get_type_description` of a node describes its types. A description has what the wire needs: names and
types of fields, of the type and of all types in it. It has no comments, constants or units, and its defaults
are not taken over.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Protocol

from goalwire.errors import InterfaceError
from goalwire.idl import registry
from goalwire.idl.model import EMPTY_MEMBER, FieldType, Shape

_PRIMITIVES = {
    2: 'int8', 3: 'uint8', 4: 'int16', 5: 'uint16', 6: 'int32', 7: 'uint32', 8: 'int64', 9: 'uint64',
    10: 'float32', 11: 'float64', 13: 'char', 15: 'bool', 16: 'byte', 17: 'string', 18: 'wstring',
    21: 'string', 22: 'wstring',
}  # fmt: skip
"""Types by their number in type_description_interfaces/msg/FieldType; 21 and 22 are bounded strings."""
_NESTED = 1
_SHAPES = {0: Shape.SINGLE, 48: Shape.ARRAY, 96: Shape.BOUNDED, 144: Shape.UNBOUNDED}
_PARTS = {'srv': ('Request', 'Response'), 'action': ('Goal', 'Result', 'Feedback')}
"""The parts that the file of a service or an action defines; all its other types are derived from these."""


class DescribedType(Protocol):
    """As type_description_interfaces/msg/FieldType."""

    type_id: int
    capacity: int
    string_capacity: int
    nested_type_name: str


class DescribedField(Protocol):
    """As type_description_interfaces/msg/Field."""

    name: str

    @property
    def type(self) -> DescribedType: ...


class IndividualDescription(Protocol):
    """As type_description_interfaces/msg/IndividualTypeDescription."""

    type_name: str

    @property
    def fields(self) -> Iterable[DescribedField]: ...


class Description(Protocol):
    """As type_description_interfaces/msg/TypeDescription."""

    @property
    def type_description(self) -> IndividualDescription: ...

    @property
    def referenced_type_descriptions(self) -> Iterable[IndividualDescription]: ...


def register_descriptions(name: str, descriptions: Iterable[Description]) -> list[str]:
    """Register a type and all types in it that are unknown here; return the full names of the new types.

    `name` is 'pkg/kind/Name', or a service's event, which contains the service's parts. `descriptions` have
    the type and the types in it; for an action its parts suffice. Compare `type_hash` afterwards: only the
    hash shows if the result is the wanted type. Raises InterfaceError if a type is missing or unreadable.
    """
    all_types = {
        each.type_name: each
        for description in descriptions
        for each in (description.type_description, *description.referenced_type_descriptions)
    }
    added = []
    package, kind, base = registry.split_name(name)
    whole = name if kind == 'msg' else f'{package}/{kind}/{base.partition("_")[0]}'
    for each in sorted({whole, *all_types}):
        package, kind, base = registry.split_name(each)
        if '_' in base or _is_known(each):
            continue  # a part is made together with its service or action
        text = _definition_text(all_types, each, kind)
        registry.register_definitions(package, {f'{kind}/{base}': text})
        added.append(each)
    return added


def _is_known(name: str) -> bool:
    try:
        registry.definition(name)
    except InterfaceError:
        return False
    return True


def _definition_text(all_types: dict[str, IndividualDescription], name: str, kind: str) -> str:
    parts = [name] if kind == 'msg' else [f'{name}_{part}' for part in _PARTS[kind]]
    missing = [part for part in parts if part not in all_types]
    if missing:
        raise InterfaceError(f'the description of {name} has no {missing[0]}')
    return '---\n'.join(''.join(_lines(all_types[part])) for part in parts)


def _lines(described: IndividualDescription) -> Iterator[str]:
    for field in described.fields:
        if field.name != EMPTY_MEMBER:
            yield f'{_type_of(field.type, described.type_name).text} {field.name}\n'


def _type_of(described: DescribedType, owner: str) -> FieldType:
    offset = max(each for each in _SHAPES if each < max(described.type_id, 1))
    number = described.type_id - offset
    base = described.nested_type_name if number == _NESTED else _PRIMITIVES.get(number)
    if not base:
        raise InterfaceError(f'{owner} has a field of the type number {described.type_id}, which is unknown')
    return FieldType(base, _SHAPES[offset], described.capacity, described.string_capacity)
