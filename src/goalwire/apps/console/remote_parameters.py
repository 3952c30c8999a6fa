"""The parameters of other nodes, by the services that every ROS 2 node has."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.errors import FieldValueError, RemoteError
from goalwire.records import record
from goalwire.rules.parameters.fitting import fit_parameter, fit_parameter_text
from goalwire.rules.parameters.parameter import FIELDS, Type, value_message

if TYPE_CHECKING:
    from goalwire.apps.console.sending import Sender
    from goalwire.apps.console.settings import Settings

_LIST = '/list_parameters'
_ANSWER_S = 10.0
_PREFIX_S = 5.0
_STRING = 4
_KINDS = (
    'not set',
    'bool',
    'integer',
    'double',
    'string',
    'byte array',
    'bool array',
    'integer array',
    'double array',
    'string array',
)


@record
class RemoteParameter:
    """A parameter of another node."""

    name: str
    number: int
    """Of the type, as in rcl_interfaces/msg/ParameterType."""
    value: Any
    description: str = ''
    constraints: str = ''
    read_only: bool = False
    least: float | None = None
    most: float | None = None
    step: float = 0.0

    @property
    def kind(self) -> str:
        """The type's name."""
        return _KINDS[self.number] if self.number < len(_KINDS) else 'unknown'


def nodes_with_parameters(services: list[tuple[str, list[str]]]) -> list[str]:
    """Return the nodes that can be asked for their parameters."""
    return [
        name.removesuffix(_LIST)
        for name, types in services
        if name.endswith(_LIST) and 'rcl_interfaces/srv/ListParameters' in types
    ]


async def read_parameters(sender: Sender, node: str) -> list[RemoteParameter]:
    """Ask a node for its parameters, with descriptors. Raises goalwire's errors where it is silent."""
    from rcl_interfaces.srv import DescribeParameters, GetParameters, ListParameters

    lister = sender.client(ListParameters, f'{node}{_LIST}', 'ListParameters')
    names = list((await lister.call(timeout=_ANSWER_S)).result.names)
    getter = sender.client(GetParameters, f'{node}/get_parameters', 'GetParameters')
    describer = sender.client(DescribeParameters, f'{node}/describe_parameters', 'DescribeParameters')
    values = (await getter.call(names=names, timeout=_ANSWER_S)).values
    described = (await describer.call(names=names, timeout=_ANSWER_S)).descriptors
    found = [
        _parameter(name, value, about) for name, value, about in zip(names, values, described, strict=False)
    ]
    return sorted(found, key=lambda parameter: parameter.name)


async def frame_prefix(node: goalwire.Node, owner: str) -> str | None:
    """Ask a node for its parameter `frame_prefix`; None if it does not answer or has none."""
    from rcl_interfaces.srv import GetParameters

    try:
        client = node.client(GetParameters, f'{owner}/get_parameters')
    except goalwire.GoalwireError:
        return None  # a peer may have any name
    try:
        values = (await client.call(names=['frame_prefix'], timeout=_PREFIX_S)).values
    except goalwire.GoalwireError:
        return None
    finally:
        client.close()
    return values[0].string_value.lstrip('/') if values and values[0].type == _STRING else None


def _parameter(name: str, value: Any, about: Any) -> RemoteParameter:
    number = value.type if value.type < len(_KINDS) else 0
    held: Any = getattr(value, FIELDS[Type(number)]) if number else None
    if number == 5:
        held = [each[0] if isinstance(each, bytes) else int(each) for each in held]
    elif number > 5:
        held = list(held)
    bounds = [*about.floating_point_range, *about.integer_range]
    bound = bounds[0] if bounds else None
    return RemoteParameter(
        name,
        number,
        held,
        about.description,
        about.additional_constraints,
        about.read_only,
        None if bound is None else bound.from_value,
        None if bound is None else bound.to_value,
        0.0 if bound is None else float(bound.step),
    )


def fitted_value(parameter: RemoteParameter, typed: object) -> Any:
    """Return the value of a parameter that a form's text or switch stands for, or a value of its type.

    Raises FieldValueError, for a number outside the range that the parameter declares, too.
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
        if not low <= value <= high:  # NaN, too
            reason = f'give a number from {low:g} to {high:g}, not {value:g}'
            raise FieldValueError(parameter.name, reason, parameter.kind)
    return value


async def set_parameter(
    sender: Sender, settings: Settings, node: str, parameter: RemoteParameter, value: Any
) -> None:
    """Set a parameter to a value that `fitted_value` has returned.

    Raises NotAllowedError, RemoteError if the node says no, goalwire's own errors if it does not answer.
    """
    from rcl_interfaces.msg import Parameter
    from rcl_interfaces.srv import SetParameters

    settings.check_may_send(node)
    message = Parameter(name=parameter.name, value=value_message(Type(parameter.number), value))
    client = sender.client(SetParameters, f'{node}/set_parameters', 'SetParameters')
    [result] = (await client.call(parameters=[message], timeout=_ANSWER_S)).results
    if not result.successful:
        raise RemoteError(result.reason or 'the node refused the value')
