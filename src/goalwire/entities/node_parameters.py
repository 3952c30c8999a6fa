"""The parameters of a node: declared, overridden by arguments, read and set."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from goalwire.entities.exceptions import (
    InvalidParameterException,
    InvalidParameterTypeException,
    ParameterAlreadyDeclaredException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
)
from goalwire.protocol.parameters import Parameter, ParameterTable, ParameterValue, Type

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore


class NodeParameters:
    """Mixed into Node. The values live in a ParameterTable; what callers see is rclpy's."""

    core: NodeCore

    def _init_parameters(
        self, overrides: Iterable[Parameter], *, allow_undeclared: bool, declare_overrides: bool
    ) -> None:
        values: dict[str, ParameterValue] = dict(self.core.parameter_overrides())
        values.update({parameter.name: parameter.value for parameter in overrides})
        self._parameters = ParameterTable(values, allow_undeclared=allow_undeclared)
        if declare_overrides:
            for name, value in values.items():
                self.declare_parameter(name, value, ignore_override=True)

    def declare_parameter(
        self, name: str, value: Any = None, descriptor: Any = None, ignore_override: bool = False
    ) -> Parameter:
        """Declare a parameter with a default value (or, without one, a Type) and return it.

        An override from `--ros-args -p` wins over the default. Raises ParameterAlreadyDeclaredException,
        InvalidParameterException, InvalidParameterTypeException.
        """
        _check_name(name)
        if not name:
            raise InvalidParameterException(name)
        if name in self._parameters:
            raise ParameterAlreadyDeclaredException([name])
        dynamic = bool(descriptor is not None and descriptor.dynamic_typing)
        default = Parameter(name, Type.NOT_SET) if isinstance(value, Type) else Parameter(name, value=value)
        expected = value if isinstance(value, Type) else default.type_
        override = self._parameters.overrides.get(name)
        if override is not None and not ignore_override and expected is not Type.NOT_SET and not dynamic:
            wanted = Parameter(name, value=override)
            if wanted.type_ is not expected:
                raise InvalidParameterTypeException(wanted, expected.name)
        self._parameters.declare(name, default, expected, ignore_override=ignore_override, dynamic=dynamic)
        found = self._parameters.get(name)
        assert found is not None
        return found

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare several, each `(name[, value[, descriptor]])`, under a namespace (may be '')."""
        prefix = f'{namespace}.' if namespace else ''
        return [
            self.declare_parameter(_below(prefix, name), *_value_and_descriptor(rest), ignore_override)
            for name, *rest in parameters
        ]

    def undeclare_parameter(self, name: str) -> None:
        """Forget a parameter; raises ParameterNotDeclaredException."""
        if name not in self._parameters:
            raise ParameterNotDeclaredException(name)
        self._parameters.undeclare(name)

    def has_parameter(self, name: str) -> bool:
        """True where the parameter is declared."""
        return name in self._parameters

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter; raises ParameterNotDeclaredException or ParameterUninitializedException."""
        found = self._parameters.get(name)
        if found is None:
            if self._parameters.allow_undeclared:
                return Parameter(name)
            raise ParameterNotDeclaredException(name)
        if found.type_ is Type.NOT_SET and self._parameters.is_static(name):
            raise ParameterUninitializedException(name)
        return found

    def get_parameters(self, names: Sequence[str]) -> list[Parameter]:
        """Return several parameters; raises as get_parameter does."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or the alternative where it is not there or has no value."""
        found = self._parameters.get(name)
        if found is None or found.type_ is Type.NOT_SET:
            return alternative_value or Parameter(name)
        return found

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by the rest of their names."""
        start = f'{prefix}.' if prefix else ''
        table = self._parameters
        return {
            name[len(start) :]: self.get_parameter(name) for name in table.names() if name.startswith(start)
        }

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[Any]:
        """Set each parameter on its own; returns one rcl_interfaces/msg/SetParametersResult for each.

        Raises ParameterNotDeclaredException, TypeError for what is no Parameter.
        """
        from rcl_interfaces.msg import SetParametersResult

        results = []
        for parameter in parameter_list:
            _check_parameter(parameter)
            if parameter.name not in self._parameters and not self._parameters.allow_undeclared:
                raise ParameterNotDeclaredException([parameter.name])
            refusal = self._parameters.refusal(parameter)
            if not refusal:
                self._parameters.set(parameter)
            results.append(SetParametersResult(successful=not refusal, reason=refusal))
        return results


def _check_name(name: object) -> None:
    if not isinstance(name, str):
        raise TypeError(f'First element {name} at index 0 in parameters list is not a str.')


def _check_parameter(parameter: object) -> None:
    if not isinstance(parameter, Parameter):
        raise TypeError(f"parameter must be instance of type '{Parameter!r}'")


def _below(prefix: str, name: Any) -> str:
    _check_name(name)
    return f'{prefix}{name}'


def _value_and_descriptor(rest: Sequence[Any]) -> tuple[Any, Any]:
    if len(rest) > 2:
        raise TypeError(
            f'Invalid parameter tuple length; expecting a name and at most two more, got {rest!r}'
        )
    value, descriptor = (*rest, None, None)[:2]
    return value, descriptor
