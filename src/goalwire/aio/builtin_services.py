"""What every node of ROS 2 has beside its program's own: logs, parameters, time, the services about them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from goalwire.aio.parameters import ParameterStore
from goalwire.aio.service import LoggedService
from goalwire.entities.parameters.services import ParameterServices
from goalwire.entities.time_source import USE_SIM_TIME_NAME, ClockSubscription, TimeSourceCore
from goalwire.entities.type_description import TypeDescriptions
from goalwire.execution.callback_groups import MutuallyExclusiveCallbackGroup
from goalwire.rules.qos import PARAMETERS, ROSOUT, SERVICES_DEFAULT, QoS

if TYPE_CHECKING:
    from goalwire.entities.node import NodeCore
    from goalwire.entities.type_support import ServiceSupport
    from goalwire.rules.parameters import ParameterValue


def stand(core: NodeCore, overrides: Mapping[str, ParameterValue]) -> ParameterStore:
    """Make the standing parts of a node, in ROS 2's order, and return its parameters.

    Raises InvalidParameterTypeException and its kin for an override that does not fit.
    """
    if core.context.arguments.rosout_logs:
        core.context.rosout.join(core, ROSOUT)
    store = ParameterStore(core, overrides)
    TimeSource(core, store)
    ParameterServices(store).offer(_offering(core, PARAMETERS))
    descriptions = TypeDescriptions(store)
    if descriptions.wanted():
        descriptions.offer(_offering(core, SERVICES_DEFAULT))
    return store


def _offering(core: NodeCore, qos: QoS) -> Callable[[ServiceSupport, str, Callable[..., object]], object]:
    def offer(support: ServiceSupport, name: str, callback: Callable[..., object]) -> LoggedService:
        return LoggedService(core, support, name, callback, qos, concurrent=False)

    return offer


class TimeSource(TimeSourceCore):
    """Sets a node's clock from /clock, under its parameter `use_sim_time`."""

    def __init__(self, core: NodeCore, store: ParameterStore) -> None:
        super().__init__()
        self._core = core
        if not store.has_parameter(USE_SIM_TIME_NAME):
            store.declare_parameter(USE_SIM_TIME_NAME, False)
        self.attach_clock(core.clock)
        self._follow([store.get_parameter(USE_SIM_TIME_NAME)])
        store.add_post_set_parameters_callback(self._follow)

    def _subscribe(self) -> None:
        self.subscription = ClockSubscription(self._core, MutuallyExclusiveCallbackGroup(), self)

    def _unsubscribe(self) -> None:
        subscription, self.subscription = self.subscription, None
        if subscription is not None:
            subscription.destroy()
