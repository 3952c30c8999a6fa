"""rclpy.parameter_client: reads and sets the parameters of another node."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

from goalwire.entities.graph_waiting import wait_for_graph
from goalwire.entities.parameters.events import PARAMETER_EVENTS_TOPIC
from rclpy._reexports import reexport
from rclpy.parameter import Parameter, parameter_dict_from_yaml_file
from rclpy.qos import QoSProfile, qos_profile_parameter_events, qos_profile_services_default

if TYPE_CHECKING:
    from rcl_interfaces.msg import Parameter as ParameterMessage
    from rcl_interfaces.msg import ParameterEvent
    from rcl_interfaces.srv import (
        DescribeParameters,
        GetParameters,
        GetParameterTypes,
        ListParameters,
        SetParameters,
        SetParametersAtomically,
    )

    from rclpy.callback_groups import CallbackGroup
    from rclpy.client import Client
    from rclpy.event_handler import SubscriptionEventCallbacks
    from rclpy.node import Node
    from rclpy.qos_overriding_options import QoSOverridingOptions
    from rclpy.subscription import Subscription
    from rclpy.task import Future

    AnyParameter: TypeAlias = Parameter | ParameterMessage

RequestT = TypeVar('RequestT')
ResponseT = TypeVar('ResponseT')


class AsyncParameterClient:
    """Calls the parameter services of a node; each method returns the future of the service's response."""

    def __init__(
        self,
        node: Node,
        remote_node_name: str,
        qos_profile: QoSProfile = qos_profile_services_default,
        callback_group: CallbackGroup | None = None,
    ) -> None:
        """Make a client for the node named 'name' or '/ns/name'; raises InvalidServiceNameException."""
        from rcl_interfaces import srv

        def client(srv_type: Any, service: str) -> Client[Any, Any]:
            name = f'{remote_node_name}/{service}'
            return node.create_client(srv_type, name, qos_profile=qos_profile, callback_group=callback_group)

        self.remote_node_name = remote_node_name
        self.node = node
        self._get_parameter_client = client(srv.GetParameters, 'get_parameters')
        self._list_parameter_client = client(srv.ListParameters, 'list_parameters')
        self._set_parameter_client = client(srv.SetParameters, 'set_parameters')
        self._get_parameter_types_client = client(srv.GetParameterTypes, 'get_parameter_types')
        self._describe_parameters_client = client(srv.DescribeParameters, 'describe_parameters')
        self._set_parameters_atomically_client = client(
            srv.SetParametersAtomically, 'set_parameters_atomically'
        )

    def services_are_ready(self) -> bool:
        """True while all six parameter services are available."""
        return all(
            client.service_is_ready()
            for client in (
                self._list_parameter_client,
                self._set_parameter_client,
                self._get_parameter_client,
                self._get_parameter_types_client,
                self._describe_parameters_client,
                self._set_parameters_atomically_client,
            )
        )

    def wait_for_services(self, timeout_sec: float | None = None) -> bool:
        """Block until all six services are available; False after the timeout. No executor is needed."""
        return wait_for_graph(self.node.context, self.services_are_ready, timeout_sec)

    def list_parameters(
        self,
        prefixes: list[str] | None = None,
        depth: int | None = None,
        callback: Callable[[Future[ListParameters.Response]], object] | None = None,
    ) -> Future[ListParameters.Response]:
        """List the names at or below prefixes (None: all), `depth` parts deep at most (None, 0: any)."""
        from rcl_interfaces.srv import ListParameters

        request = ListParameters.Request(prefixes=prefixes or [], depth=depth or 0)
        return _call(self._list_parameter_client, request, callback)

    def get_parameters(
        self, names: list[str], callback: Callable[[Future[GetParameters.Response]], object] | None = None
    ) -> Future[GetParameters.Response]:
        """Get values of parameters; the response is empty if a parameter does not exist or has no value."""
        from rcl_interfaces.srv import GetParameters

        return _call(self._get_parameter_client, GetParameters.Request(names=names), callback)

    def set_parameters(
        self,
        parameters: Sequence[AnyParameter],
        callback: Callable[[Future[SetParameters.Response]], object] | None = None,
    ) -> Future[SetParameters.Response]:
        """Set each parameter independently; the response has one result for each parameter."""
        from rcl_interfaces.srv import SetParameters

        request = SetParameters.Request(parameters=_messages(parameters))
        return _call(self._set_parameter_client, request, callback)

    def describe_parameters(
        self,
        names: list[str],
        callback: Callable[[Future[DescribeParameters.Response]], object] | None = None,
    ) -> Future[DescribeParameters.Response]:
        """Get descriptors of parameters; the response is empty if a parameter does not exist."""
        from rcl_interfaces.srv import DescribeParameters

        return _call(self._describe_parameters_client, DescribeParameters.Request(names=names), callback)

    def get_parameter_types(
        self,
        names: list[str],
        callback: Callable[[Future[GetParameterTypes.Response]], object] | None = None,
    ) -> Future[GetParameterTypes.Response]:
        """Get types of parameters; the response is empty if a parameter does not exist."""
        from rcl_interfaces.srv import GetParameterTypes

        return _call(self._get_parameter_types_client, GetParameterTypes.Request(names=names), callback)

    def set_parameters_atomically(
        self,
        parameters: Sequence[AnyParameter],
        callback: Callable[[Future[SetParametersAtomically.Response]], object] | None = None,
    ) -> Future[SetParametersAtomically.Response]:
        """Set all the parameters together: all, or none if one is refused."""
        from rcl_interfaces.srv import SetParametersAtomically

        request = SetParametersAtomically.Request(parameters=_messages(parameters))
        return _call(self._set_parameters_atomically_client, request, callback)

    def delete_parameters(
        self, names: list[str], callback: Callable[[Future[SetParameters.Response]], object] | None = None
    ) -> Future[SetParameters.Response]:
        """Undeclare parameters of the other node; this works only for dynamically typed parameters."""
        return self.set_parameters([Parameter(name) for name in names], callback)

    def load_parameter_file(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future[SetParameters.Response]], object] | None = None,
    ) -> Future[SetParameters.Response]:
        """Set the parameters of all nodes in a file; raises as parameter_dict_from_yaml_file does."""
        parameters = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters(list(parameters.values()), callback)

    def load_parameter_file_atomically(
        self,
        parameter_file: str,
        use_wildcard: bool = False,
        callback: Callable[[Future[SetParametersAtomically.Response]], object] | None = None,
    ) -> Future[SetParametersAtomically.Response]:
        """Set a file's parameters together: all or none; raises as parameter_dict_from_yaml_file does."""
        parameters = parameter_dict_from_yaml_file(parameter_file, use_wildcard)
        return self.set_parameters_atomically(list(parameters.values()), callback)

    def on_parameter_event(
        self,
        callback: Callable[[ParameterEvent], object],
        qos_profile: QoSProfile = qos_profile_parameter_events,
        *,
        callback_group: CallbackGroup | None = None,
        event_callbacks: SubscriptionEventCallbacks | None = None,
        qos_overriding_options: QoSOverridingOptions | None = None,
        raw: bool = False,
    ) -> Subscription[ParameterEvent]:
        """Subscribe to the /parameter_events of all nodes; raises as Node.create_subscription does."""
        from rcl_interfaces.msg import ParameterEvent

        return self.node.create_subscription(
            ParameterEvent,
            PARAMETER_EVENTS_TOPIC,
            callback,
            qos_profile,
            callback_group=callback_group,
            event_callbacks=event_callbacks,
            qos_overriding_options=qos_overriding_options,
            raw=raw,
        )


def _messages(parameters: Sequence[AnyParameter]) -> list[ParameterMessage]:
    return [
        parameter.to_parameter_msg() if isinstance(parameter, Parameter) else parameter
        for parameter in parameters
    ]


def _call(
    client: Client[RequestT, ResponseT],
    request: RequestT,
    callback: Callable[[Future[ResponseT]], object] | None,
) -> Future[ResponseT]:
    future = client.call_async(request)
    if callback is not None:
        future.add_done_callback(callback)
    return future


reexport(__name__)
