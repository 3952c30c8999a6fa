"""Reads and sets the parameters of another node through the parameter services that ROS 2 nodes have."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Self

from goalwire.errors import FieldValueError
from goalwire.records import record
from goalwire.rules.parameters.fitting import KIND_NAMES, fit_parameter, fit_parameter_text
from goalwire.rules.parameters.messages import value_of
from goalwire.rules.parameters.parameter import Type

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import goalwire

LIST = '/list_parameters'
STANDARD_SERVICES = (
    '/describe_parameters',
    '/get_parameter_types',
    '/get_parameters',
    LIST,
    '/set_parameters',
    '/set_parameters_atomically',
    '/get_type_description',
)
"""The last parts of the names of the services that every node has."""
_NOT_SET = Type.NOT_SET.value


def kind_name(number: int) -> str:
    """Return the word that `ros2 param` prints for a type, given its number in
    rcl_interfaces/msg/ParameterType.
    """
    if number == _NOT_SET:
        return 'not set'
    return KIND_NAMES[Type(number)] if number < len(Type) else f'unknown ({number})'


def plain_value(message: Any) -> Any:
    """Return the value of an rcl_interfaces/msg/ParameterValue in types of JSON: bytes become numbers.

    Raises RuntimeError for a type that ROS 2 does not have.
    """
    value = value_of(message)
    if not isinstance(value, list):
        return value
    return [each[0] if isinstance(each, bytes) else each for each in value]


def nodes_with_parameters(services: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """Return the names of the nodes that have parameter services."""
    return [
        name.removesuffix(LIST)
        for name, types in services
        if name.endswith(LIST) and 'rcl_interfaces/srv/ListParameters' in types
    ]


class NodeParameters:
    """Access to the parameters of one node: a context manager, which closes its clients at the end of the
    block.
    """

    def __init__(self, node: goalwire.Node, name: str, timeout: float) -> None:
        """The requests of `node` go to the node with the name `name`, which may take `timeout` s for each
        answer.

        Each method raises goalwire's own errors if no answer comes.
        """
        self._node = node
        self._name = name
        self._timeout = timeout
        self._clients: dict[str, goalwire.Client[Any, Any]] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_error: object) -> None:
        for client in self._clients.values():
            client.close()

    async def _ask(self, cls: Any, service: str, **fields: Any) -> Any:
        if service not in self._clients:
            self._clients[service] = self._node.client(cls, f'{self._name}/{service}')
        return await self._clients[service].call(cls.Request(**fields), timeout=self._timeout)

    async def names(self, prefixes: Sequence[str] = ()) -> list[str]:
        """Return the names of the parameters, sorted. The prefix `arm` selects parameters such as
        `arm.reach`.
        """
        from rcl_interfaces.srv import ListParameters

        response = await self._ask(ListParameters, 'list_parameters', prefixes=list(prefixes))
        return sorted(response.result.names)

    async def values(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the ParameterValue messages of these parameters; parameters without a value are left out."""
        found = await self._values(names) if names else []
        if len(found) != len(names):
            # A node returns no values at all if one of the parameters has a type but no value yet.
            alone = [await self._values([name]) for name in names]
            pairs = [(name, each[0]) for name, each in zip(names, alone, strict=True) if each]
        else:
            pairs = list(zip(names, found, strict=True))
        return {name: value for name, value in pairs if value.type != _NOT_SET}

    async def _values(self, names: Sequence[str]) -> list[Any]:
        from rcl_interfaces.srv import GetParameters

        return list((await self._ask(GetParameters, 'get_parameters', names=list(names))).values)

    async def descriptors(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the ParameterDescriptor messages of these parameters; parameters that the node lacks are
        left out.
        """
        found = await self._descriptors(names)
        if len(found) != len(names):  # a node returns nothing at all if it lacks one parameter
            known = set(await self.names())
            names = [name for name in names if name in known]
            found = await self._descriptors(names)
        return dict(zip(names, found, strict=False))

    async def _descriptors(self, names: Sequence[str]) -> list[Any]:
        from rcl_interfaces.srv import DescribeParameters

        if not names:
            return []
        response = await self._ask(DescribeParameters, 'describe_parameters', names=list(names))
        return list(response.descriptors)

    async def set(self, values: Sequence[tuple[str, Any]]) -> list[tuple[str, Any]]:
        """Set parameters to the values of ParameterValue messages, one after the other.

        Return each name with its SetParametersResult.
        """
        from rcl_interfaces.msg import Parameter
        from rcl_interfaces.srv import SetParameters

        if not values:
            return []
        parameters = [Parameter(name=name, value=value) for name, value in values]
        response = await self._ask(SetParameters, 'set_parameters', parameters=parameters)
        return list(zip([name for name, _ in values], response.results, strict=False))

    async def read(self) -> list[RemoteParameter]:
        """Return all parameters of the node, with their values and descriptions."""
        names = await self.names()
        values, descriptors = await self.values(names), await self.descriptors(names)
        return [_parameter(name, values.get(name), about) for name, about in descriptors.items()]


@record
class RemoteParameter:
    """A parameter of another node."""

    name: str
    number: int
    """The number of the parameter's type, as in rcl_interfaces/msg/ParameterType."""
    value: Any
    description: str = ''
    constraints: str = ''
    read_only: bool = False
    least: float | None = None
    most: float | None = None
    step: float = 0.0

    @property
    def kind(self) -> str:
        """The name of the parameter's type."""
        return kind_name(self.number)


def _parameter(name: str, value: Any, about: Any) -> RemoteParameter:
    number = value.type if value is not None and value.type < len(Type) else _NOT_SET
    bounds = [*about.floating_point_range, *about.integer_range]
    bound = bounds[0] if bounds else None
    return RemoteParameter(
        name,
        number,
        plain_value(value) if number else None,
        about.description,
        about.additional_constraints,
        about.read_only,
        None if bound is None else bound.from_value,
        None if bound is None else bound.to_value,
        0.0 if bound is None else float(bound.step),
    )


def fit_typed_value(parameter: RemoteParameter, typed: object) -> Any:
    """Return a parameter's value, made from a form's text or switch, or from a value of the parameter's type.

    Raises FieldValueError, also for a number outside the range that the parameter declares.
    """
    type_ = Type(parameter.number)
    if type_ is Type.NOT_SET:
        raise FieldValueError(parameter.name, 'it is not set, and so has no type')
    value: Any
    if type_ is Type.STRING:
        value = fit_parameter(parameter.name, type_, '' if typed is None else typed)
    elif isinstance(typed, str):
        value = fit_parameter_text(parameter.name, type_, typed)
    else:
        value = fit_parameter(parameter.name, type_, typed)
    least, most = parameter.least, parameter.most
    if least is not None and most is not None and isinstance(value, int | float):
        low, high = min(least, most), max(least, most)
        if not low <= value <= high:  # written so that NaN is refused, too
            reason = f'give a number from {low:g} to {high:g}, not {value:g}'
            raise FieldValueError(parameter.name, reason, parameter.kind)
    return value
