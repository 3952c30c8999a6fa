"""Makes immutable classes like `@dataclass(frozen=True, slots=True)`, in a fifth of the time.

A dataclass takes 0.5 ms to make, and the first one imports inspect, ast and tokenize: twenty-five of them
were a fifth of the time from a program's first line to its node. Type checkers and the functions of
`dataclasses` treat records as dataclasses.

Which kind of class goalwire uses: values that never change are records, which equal only records of the same
class. Values that are unpacked, sorted, or made for every message are NamedTuples, since C code makes and
compares tuples. Objects that change have plain classes. Only classes whose fields users set are dataclasses,
such as Fault and Conduct.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from operator import attrgetter
from typing import Any, TypeVar, dataclass_transform

T = TypeVar('T')


@dataclass_transform(frozen_default=True)
def record(cls: type[T]) -> type[T]:
    """Turn a class with annotated fields into a record.

    Fields named in the class's `COMPARE_EXCLUDE` are neither compared nor hashed. Fields without a default
    come first; all records share a default, so it must be immutable. The class may have a `__repr__` of its
    own, and a `__post_init__` that refuses values.
    """
    names = tuple(cls.__annotations__)
    namespace = dict(vars(cls))
    defaults = {name: namespace.pop(name) for name in names if name in namespace}
    compared = tuple(name for name in names if name not in namespace.get('COMPARE_EXCLUDE', ()))
    for name in ('__dict__', '__weakref__'):
        namespace.pop(name, None)
    own_repr = {'__repr__': namespace['__repr__']} if '__repr__' in namespace else {}
    namespace |= {'__slots__': names, '__match_args__': names, '__record_defaults__': defaults}
    namespace |= {**_methods(names, compared), **own_repr}
    namespace |= {name: _OfTwin(name) for name in ('__dataclass_fields__', '__dataclass_params__')}
    metaclass: Any = type(cls)
    made = metaclass(cls.__name__, cls.__bases__, namespace)
    made.__qualname__ = cls.__qualname__
    made.__init__ = _first_init(made)
    return made  # type: ignore[no-any-return]


def replace(made: T, **changes: object) -> T:
    """Return a copy of a record with some fields changed; raises TypeError for an unknown field."""
    cls: Any = type(made)
    values = {name: getattr(made, name) for name in cls.__match_args__}
    return cls(**values | changes)  # type: ignore[no-any-return]


class _OfTwin:
    """Gives a record an attribute that the module `dataclasses` looks for, taken from an equivalent
    dataclass.
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def __get__(self, _instance: object, owner: type) -> object:
        return getattr(_twin(owner), self._name)


@cache
def _twin(cls: Any) -> type:
    """Make the equivalent dataclass of a record when it is first needed: for `asdict`, `replace`, `fields` or
    pprint.
    """
    from dataclasses import field, make_dataclass

    fields: list[Any] = []
    for name in cls.__match_args__:
        if name in cls.__record_defaults__:
            fields.append((name, Any, field(default_factory=partial(_same, cls.__record_defaults__[name]))))
        else:
            fields.append((name, Any))
    return make_dataclass(cls.__name__, fields, frozen=True)


def _same(value: T) -> T:
    return value


def _methods(names: tuple[str, ...], compared: tuple[str, ...]) -> dict[str, object]:
    """Return the methods of a record class, except its constructor."""
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


def _first_init(cls: Any) -> Callable[..., None]:
    """Return a constructor that compiles the real one at its first call.

    To compile is a third of what a record costs at its import, and most programs use few of them.
    """

    def __init__(self: object, *values: object, **more: object) -> None:  # noqa: N807
        cls.__init__ = _compile_init(cls, cls.__match_args__, cls.__record_defaults__)
        cls.__init__(self, *values, **more)

    return __init__


def _compile_init(cls: type, names: tuple[str, ...], defaults: dict[str, object]) -> Callable[..., None]:
    """Compile a constructor that sets the slots directly, without `__setattr__`, which raises."""
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
