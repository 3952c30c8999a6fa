"""The six services through which other nodes read and set a node's parameters (rcl_interfaces/srv)."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.entities.standard_types import standard_service
from goalwire.errors import InvalidHandle, ParameterNotDeclaredException, ParameterUninitializedException
from goalwire.rules.parameters import Outcome, Parameter, Type
from goalwire.rules.parameters.messages import result_message
from goalwire.rules.qos import PARAMETERS

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import SetParametersResult
    from rcl_interfaces.srv import (
        DescribeParameters,
        GetParameters,
        GetParameterTypes,
        ListParameters,
        SetParameters,
        SetParametersAtomically,
    )

    from goalwire.entities.parameters.node_parameters import NodeParameters


class ParameterServices:
    """Answers for one node. A question that names an unknown parameter gets an empty answer, as in rclpy."""

    def __init__(self, node: NodeParameters) -> None:
        self._node = node

    def offer(self) -> None:
        """Make the services, in ROS 2's order."""
        core = self._node.handle
        name = core.name.name
        for service, type_name, answer in (
            ('describe_parameters', 'DescribeParameters', self._describe),
            ('get_parameters', 'GetParameters', self._get),
            ('get_parameter_types', 'GetParameterTypes', self._get_types),
            ('list_parameters', 'ListParameters', self._list),
            ('set_parameters', 'SetParameters', self._set),
            ('set_parameters_atomically', 'SetParametersAtomically', self._set_atomically),
        ):
            support = standard_service(f'rcl_interfaces/srv/{type_name}')
            core.make_service(support, f'{name}/{service}', answer, PARAMETERS)

    def _describe(
        self, request: DescribeParameters.Request, response: DescribeParameters.Response
    ) -> DescribeParameters.Response:
        with suppress(ParameterNotDeclaredException):
            response.descriptors = self._node.describe_parameters(request.names)
        return response

    def _get(
        self, request: GetParameters.Request, response: GetParameters.Response
    ) -> GetParameters.Response:
        try:
            found = self._node.get_parameters(request.names)
        except (ParameterNotDeclaredException, ParameterUninitializedException):
            return response
        response.values = [parameter.get_parameter_value() for parameter in found]
        return response

    def _get_types(
        self, request: GetParameterTypes.Request, response: GetParameterTypes.Response
    ) -> GetParameterTypes.Response:
        try:
            types = self._node.get_parameter_types(request.names)
        except ParameterNotDeclaredException:
            return response
        response.types = [type_.value if isinstance(type_, Type) else type_ for type_ in types]
        return response

    def _list(
        self, request: ListParameters.Request, response: ListParameters.Response
    ) -> ListParameters.Response:
        response.result = self._node.list_parameters(list(request.prefixes), request.depth)
        return response

    def _set(
        self, request: SetParameters.Request, response: SetParameters.Response
    ) -> SetParameters.Response:
        response.results = [self._try([message]) for message in request.parameters]
        return response

    def _set_atomically(
        self, request: SetParametersAtomically.Request, response: SetParametersAtomically.Response
    ) -> SetParametersAtomically.Response:
        response.result = self._try(request.parameters)
        return response

    def _try(self, messages: list[ParameterMessage]) -> SetParametersResult:
        """Set all parameters or none. The answer reports a client's mistake; callbacks' errors propagate."""
        try:
            parameters = [Parameter.from_parameter_msg(message) for message in messages]
        except ValueError as error:  # some client sent a parameter type that does not exist
            return result_message(Outcome(successful=False, reason=str(error)))
        try:
            return self._node.set_parameters_atomically(parameters)
        except (ParameterNotDeclaredException, InvalidHandle) as error:
            return result_message(Outcome(successful=False, reason=str(error)))
