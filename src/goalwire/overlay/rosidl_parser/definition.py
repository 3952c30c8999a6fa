"""The types of fields, with the names and attributes of rosidl_parser.definition."""

from __future__ import annotations

from collections.abc import Iterable

SIGNED_INTEGER_TYPES = ('short', 'long', 'long long', 'int8', 'int16', 'int32', 'int64')
UNSIGNED_INTEGER_TYPES = (
    'unsigned short', 'unsigned long', 'unsigned long long', 'uint8', 'uint16', 'uint32', 'uint64',
)  # fmt: skip
INTEGER_TYPES = (*SIGNED_INTEGER_TYPES, *UNSIGNED_INTEGER_TYPES)
FLOATING_POINT_TYPES = ('float', 'double', 'long double')
CHARACTER_TYPES = ('char', 'wchar')
BOOLEAN_TYPE = 'boolean'
OCTET_TYPE = 'octet'
BASIC_TYPES = (*INTEGER_TYPES, *FLOATING_POINT_TYPES, *CHARACTER_TYPES, BOOLEAN_TYPE, OCTET_TYPE)


class AbstractType:
    """The type of a field. Two types are equal if their classes and attributes are equal."""

    __slots__: tuple[str, ...] = ()

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, type(self)) and type(self) is type(other) and self._values() == other._values()
        )

    def __hash__(self) -> int:
        return hash((type(self), self._values()))

    def _values(self) -> tuple[object, ...]:
        return tuple(
            getattr(self, name) for cls in type(self).__mro__ for name in getattr(cls, '__slots__', ())
        )


class AbstractNestableType(AbstractType):
    """The base of the types that the elements of arrays and sequences may have."""

    __slots__ = ()


class BasicType(AbstractNestableType):
    """A primitive type with its IDL name: boolean, octet, float, double, int8, …"""

    __slots__ = ('typename',)

    def __init__(self, typename: str) -> None:
        if typename not in BASIC_TYPES:
            raise AssertionError(f'{typename!r} is not a basic type')
        self.typename = typename


class NamedType(AbstractNestableType):
    """A type that is given by a name without namespaces."""

    __slots__ = ('name',)

    def __init__(self, name: str) -> None:
        self.name = name


class NamespacedType(AbstractNestableType):
    """A message type, for example with namespaces ['geometry_msgs', 'msg'] and name 'Pose'."""

    __slots__ = ('name', 'namespaces')

    def __init__(self, namespaces: Iterable[str], name: str) -> None:
        self.namespaces = list(namespaces)
        self.name = name

    def namespaced_name(self) -> tuple[str, ...]:
        return (*self.namespaces, self.name)

    def _values(self) -> tuple[object, ...]:
        return self.namespaced_name()


class AbstractGenericString(AbstractNestableType):
    """string and wstring."""

    __slots__ = ()

    def has_maximum_size(self) -> bool:
        return hasattr(self, 'maximum_size')


class AbstractString(AbstractGenericString):
    __slots__ = ()


class BoundedString(AbstractString):
    __slots__ = ('maximum_size',)

    def __init__(self, maximum_size: int) -> None:
        self.maximum_size = maximum_size


class UnboundedString(AbstractString):
    __slots__ = ()


class AbstractWString(AbstractGenericString):
    __slots__ = ()


class BoundedWString(AbstractWString):
    __slots__ = ('maximum_size',)

    def __init__(self, maximum_size: int) -> None:
        self.maximum_size = maximum_size


class UnboundedWString(AbstractWString):
    __slots__ = ()


class AbstractNestedType(AbstractType):
    """The base of the types of arrays and sequences, whose elements have the type `value_type`."""

    __slots__ = ('value_type',)

    def __init__(self, value_type: AbstractNestableType) -> None:
        self.value_type = value_type

    def has_maximum_size(self) -> bool:
        return hasattr(self, 'size') or hasattr(self, 'maximum_size')


class Array(AbstractNestedType):
    __slots__ = ('size',)

    def __init__(self, value_type: AbstractNestableType, size: int) -> None:
        super().__init__(value_type)
        self.size = size


class AbstractSequence(AbstractNestedType):
    __slots__ = ()


class BoundedSequence(AbstractSequence):
    __slots__ = ('maximum_size',)

    def __init__(self, value_type: AbstractNestableType, maximum_size: int) -> None:
        super().__init__(value_type)
        self.maximum_size = maximum_size


class UnboundedSequence(AbstractSequence):
    __slots__ = ()
