"""The table of a node's parameters, and the overrides for parameters that are declared later."""

from __future__ import annotations

from collections.abc import ItemsView, Iterator, Mapping, Sequence, ValuesView
from threading import Lock

from goalwire.rules.parameters.descriptor import Descriptor
from goalwire.rules.parameters.outcome import ACCEPTED, Outcome, refuse
from goalwire.rules.parameters.parameter import Parameter, ParameterValue, Type


class Changes:
    """The parameters that one set has added, changed and deleted, as /parameter_events reports them."""

    __slots__ = ('changed', 'deleted', 'new')

    def __init__(self) -> None:
        self.new: list[Parameter] = []
        self.changed: list[Parameter] = []
        self.deleted: list[Parameter] = []

    def __bool__(self) -> bool:
        return bool(self.new or self.changed or self.deleted)


class ParameterTable(Mapping[str, Parameter]):
    """The declared parameters by name, in order of declaration.

    Programs know the table as `Node._parameters`. Any thread may read it without a lock. Changes are made
    one after the other, under a lock.
    """

    def __init__(self, overrides: dict[str, ParameterValue], *, allow_undeclared: bool = False) -> None:
        self.allow_undeclared = allow_undeclared
        self.overrides = overrides
        self._values: dict[str, Parameter] = {}
        self._descriptors: dict[str, Descriptor] = {}
        self._lock = Lock()

    def __contains__(self, name: object) -> bool:
        return name in self._values

    def __getitem__(self, name: str) -> Parameter:
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(tuple(self._values))

    def __len__(self) -> int:
        return len(self._values)

    def values(self) -> ValuesView[Parameter]:
        """Return all declared parameters with their present values."""
        return self._values.copy().values()

    def items(self) -> ItemsView[str, Parameter]:
        """Return pairs of name and parameter, as they are at present."""
        return self._values.copy().items()

    def descriptor(self, name: str) -> Descriptor | None:
        """Return the descriptor of a declared parameter; None for an undeclared parameter."""
        return self._descriptors.get(name)

    def is_uninitialized(self, parameter: Parameter) -> bool:
        """Tell whether a declared parameter has a fixed type and no value yet."""
        if parameter.type_ is not Type.NOT_SET:
            return False
        descriptor = self._descriptors.get(parameter.name)
        return descriptor is not None and not descriptor.dynamic_typing

    def judge(self, parameters: Sequence[Parameter]) -> Outcome:
        """Return whether the given values may be set. Undeclared parameters are not checked."""
        for parameter in parameters:
            descriptor = self._descriptors.get(parameter.name)
            if descriptor is None:
                continue
            if descriptor.read_only:
                return refuse(f'Trying to set a read-only parameter: {parameter.name}.')
            outcome = descriptor.judge(parameter, declared=True)
            if not outcome.successful:
                return outcome
        return ACCEPTED

    def store(
        self, parameters: Sequence[Parameter], declared: Mapping[str, Descriptor] | None = None
    ) -> Changes:
        """Store accepted parameters, all at once.

        With `declared`, the parameters are declared with its descriptors. Without `declared`, a parameter
        without a value is removed, and an undeclared parameter is added.
        """
        changes = Changes()
        with self._lock:
            for parameter in parameters:
                if declared is not None:
                    self._store(parameter, declared[parameter.name], changes)
                elif parameter.type_ is Type.NOT_SET:
                    self._remove(parameter, changes)
                else:
                    known = self._descriptors.get(parameter.name)
                    self._store(parameter, known or Descriptor(parameter.name, dynamic_typing=True), changes)
        return changes

    def describe(self, descriptor: Descriptor, parameter: Parameter) -> None:
        """Give a declared parameter another descriptor and a value that fits it."""
        with self._lock:
            self._values[parameter.name] = parameter
            self._descriptors[parameter.name] = _following(
                descriptor._replace(name=parameter.name), parameter
            )

    def undeclare(self, name: str) -> None:
        """Remove a declared parameter."""
        with self._lock:
            self._values.pop(name, None)
            self._descriptors.pop(name, None)

    def _store(self, parameter: Parameter, descriptor: Descriptor, changes: Changes) -> None:
        before = self._values.get(parameter.name)
        is_new = before is None or before.type_ is Type.NOT_SET
        (changes.new if is_new else changes.changed).append(parameter)
        self._values[parameter.name] = parameter
        self._descriptors[parameter.name] = _following(descriptor, parameter)

    def _remove(self, parameter: Parameter, changes: Changes) -> None:
        before = self._values.pop(parameter.name, None)
        self._descriptors.pop(parameter.name, None)
        if before is not None:
            changes.deleted.append(parameter)


def _following(descriptor: Descriptor, parameter: Parameter) -> Descriptor:
    """Return `descriptor`, with the type of the present value if the parameter is dynamically typed."""
    if descriptor.dynamic_typing and descriptor.type is not parameter.type_:
        return descriptor._replace(type=parameter.type_)
    return descriptor
