"""Immutable classes with named fields: what `@dataclass(frozen=True, slots=True)` makes, for a fifth of it.

A dataclass takes 0.5 ms to make, and the first one imports inspect, ast and tokenize: twenty-five of them
were a fifth of the time from a program's first line to its node. Type checkers take records for dataclasses,
and so do the functions of `dataclasses`.

A value that is never changed is a record: it equals records of its own class alone. It is a NamedTuple if it
is unpacked, sorted, or made for every message, since C makes and compares tuples. Whatever changes is a plain
class. Only the classes whose fields users set are dataclasses: a Fault, a scripted action's Conduct.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from operator import attrgetter
from typing import Any, TypeVar, dataclass_transform

T = TypeVar('T')


@dataclass_transform(frozen_default=True)
def record(cls: type[T]) -> type[T]:
    """Make a class with annotated fields a record.

    Fields named in its `COMPARE_EXCLUDE` are neither compared nor hashed. Fields without a default come
    first; a default is shared by all records, so it is never changed. Its own `__repr__` stays, and its
    `__post_init__` may refuse values.
    """
    names = tuple(cls.__annotations__)
    namespace = dict(vars(cls))
    defaults = {name: namespace.pop(name) for name in names if name in namespace}
    compared = tuple(name for name in names if name not in namespace.get('COMPARE_EXCLUDE', ()))
    for name in ('__dict__', '__weakref__'):
        namespace.pop(name, None)
    own_repr = {'__repr__': namespace['__repr__']} if '__repr__' in namespace else {}
    namespace |= {'__slots__': names, '__match_args__': names, **_methods(names, compared), **own_repr}
    namespace |= {name: _OfTwin(name) for name in ('__dataclass_fields__', '__dataclass_params__')}
    metaclass: Any = type(cls)
    made = metaclass(cls.__name__, cls.__bases__, namespace)
    made.__qualname__ = cls.__qualname__
    made.__init__ = _init(made, names, defaults)
    return made  # type: ignore[no-any-return]


def replace(made: T, **changes: object) -> T:
    """Return a copy of a record with some fields changed; raises TypeError for one that it does not have."""
    cls: Any = type(made)
    values = {name: getattr(made, name) for name in cls.__match_args__}
    return cls(**values | changes)  # type: ignore[no-any-return]


class _OfTwin:
    """An attribute that `dataclasses` looks for: that of a dataclass with the record's fields."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, _instance: object, owner: type) -> object:
        return getattr(_twin(owner), self._name)


@cache
def _twin(cls: Any) -> type:
    """Make the dataclass when somebody asks for it: for `asdict`, `replace`, `fields` or pprint."""
    from dataclasses import field, make_dataclass

    names, defaults = cls.__match_args__, cls.__init__.__defaults__ or ()
    first = len(names) - len(defaults)
    fields: list[Any] = [(name, Any) for name in names[:first]]
    for name, default in zip(names[first:], defaults, strict=True):
        fields.append((name, Any, field(default_factory=partial(_same, default))))
    return make_dataclass(cls.__name__, fields, frozen=True)


def _same(value: T) -> T:
    return value


def _methods(names: tuple[str, ...], compared: tuple[str, ...]) -> dict[str, object]:
    """Return what records have but their constructor."""
    values, key = _getter(names), _getter(compared)

    def __eq__(self: object, other: object) -> bool:  # noqa: N807
        return key(self) == key(other) if other.__class__ is self.__class__ else NotImplemented

    def __hash__(self: object) -> int:  # noqa: N807
        return hash(key(self))

    def __repr__(self: object) -> str:  # noqa: N807
        fields = ', '.join(f'{name}={getattr(self, name)!r}' for name in names)
        return f'{type(self).__qualname__}({fields})'

    def __setattr__(self: object, name: str, _value: object = None) -> None:  # noqa: N807
        raise AttributeError(f'{type(self).__qualname__} is immutable: {name} stays what it is')

    def __reduce__(self: object) -> tuple[object, ...]:  # noqa: N807 - copies and pickles go through __init__
        return type(self), (values(self),) if len(names) == 1 else values(self)

    methods = (__eq__, __hash__, __repr__, __setattr__, __reduce__)
    return {'__delattr__': __setattr__, **{method.__name__: method for method in methods}}


def _getter(names: tuple[str, ...]) -> Callable[[object], Any]:
    return attrgetter(*names) if names else lambda _: ()


def _init(cls: type, names: tuple[str, ...], defaults: dict[str, object]) -> Callable[..., None]:
    """Compile a constructor; it sets the slots directly, past `__setattr__`."""
    scope: dict[str, Any] = {f'_default_{name}': value for name, value in defaults.items()}
    scope |= {f'_set_{name}': vars(cls)[name].__set__ for name in names}
    parameters = ', '.join(f'{name}=_default_{name}' if name in defaults else name for name in names)
    body = '\n'.join(f'    _set_{name}(self, {name})' for name in names)
    if hasattr(cls, '__post_init__'):
        body += '\n    self.__post_init__()'
    exec(f'def __init__(self, {parameters}):\n{body or "    pass"}', scope)  # noqa: S102 - names of fields
    init: Callable[..., None] = scope['__init__']
    init.__qualname__ = f'{cls.__qualname__}.__init__'
    init.__module__ = cls.__module__
    return init
