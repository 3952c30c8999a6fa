"""A node's own parameters as a mapping of names to values. Other nodes read and set them over services."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from goalwire.aio.entity import Entity
from goalwire.entities.parameters.events import PARAMETER_EVENT, PARAMETER_EVENTS_TOPIC, ParameterEvents
from goalwire.entities.parameters.node_parameters import NodeParameters
from goalwire.entities.publisher import PublisherCore
from goalwire.entities.standard_types import standard_message
from goalwire.errors import InvalidParameterValueException
from goalwire.execution.asyncio.waiting import AsyncQueue
from goalwire.rules.parameters import Outcome, Parameter
from goalwire.rules.qos import PARAMETER_EVENTS

if TYPE_CHECKING:
    from typing import Self

    from goalwire.entities.node import NodeCore
    from goalwire.entities.parameters.declaration import Described
    from goalwire.rules.parameters import ParameterValue

ValueT = TypeVar('ValueT')

CHANGES_LIMIT = 1000
"""How many changes wait for one iterator; beyond this the oldest is dropped and counted."""


class ParameterStore(NodeParameters):
    """The parameters of a node under rclpy's method names, which the node's parameter services use."""

    def __init__(self, core: NodeCore, overrides: Mapping[str, ParameterValue]) -> None:
        self._core = core
        self._ros_init_parameters(
            [Parameter(name, value=value) for name, value in overrides.items()], allow_undeclared=False
        )
        publisher: PublisherCore[Any] = PublisherCore(
            core, standard_message(PARAMETER_EVENT), PARAMETER_EVENTS_TOPIC, PARAMETER_EVENTS
        )
        self._ros_parameter_events = ParameterEvents(core, publisher)

    @property
    def handle(self) -> NodeCore:
        """The node that does the work: goalwire's own, which both APIs share."""
        return self._core


class Parameters(Mapping[str, Any]):
    """A node's parameters: Node.parameters. The program, other nodes and ROS arguments set their values."""

    def __init__(self, store: ParameterStore) -> None:
        self._store = store
        self._checks: dict[str, Callable[[Any], object]] = {}
        store.add_on_set_parameters_callback(self._judge)

    def declare(
        self,
        name: str,
        default: ValueT,
        *,
        descriptor: Described | None = None,
        check: Callable[[ValueT], object] | None = None,
    ) -> ValueT:
        """Declare a parameter and return its value: an override if there is one, else the default.

        `check` is called with each new value and refuses it by raising ValueError. The caller who sets the
        value gets the error's text. Raises ParameterAlreadyDeclaredException, InvalidParameterException,
        InvalidParameterTypeException, InvalidParameterValueException, TypeError.
        """
        if check is not None:
            self._checks.setdefault(name, check)
        try:
            declared = self._store.declare_parameter(name, default, descriptor)
        except BaseException:
            if name not in self and self._checks.get(name) is check:
                self._checks.pop(name, None)
            raise
        return declared.value

    def __getitem__(self, name: str) -> Any:
        """Return a value; raises KeyError for a parameter that is not declared."""
        if name not in self:
            raise KeyError(name)
        return self._store.get_parameter(name).value

    def __setitem__(self, name: str, value: ParameterValue) -> None:
        """Set a value. Raises InvalidParameterValueException if it is refused,
        ParameterNotDeclaredException.
        """
        self.update({name: value})

    def update(self, values: Mapping[str, ParameterValue]) -> None:
        """Set several values, all or none. Raises as setting one does."""
        parameters = [Parameter(name, value=value) for name, value in values.items()]
        result = self._store.set_parameters_atomically(parameters)
        if not result.successful:
            raise InvalidParameterValueException(', '.join(values), dict(values), result.reason)

    def changes(self) -> Changes:
        """Return an async iterator of the changes from now on, each a name and a value; other nodes' changes
        count.
        """
        return Changes(self._store)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and self._store.has_parameter(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self._store.list_parameters([], 0).names)

    def __len__(self) -> int:
        return len(list(iter(self)))

    def _judge(self, parameters: list[Parameter]) -> Outcome:
        for parameter in parameters:
            check = self._checks.get(parameter.name)
            if check is None:
                continue
            try:
                check(parameter.value)
            except ValueError as error:
                return Outcome(successful=False, reason=str(error))
        return Outcome(successful=True)


class Changes(Entity):
    """An async iterator of changes: `async for name, value in changes`. The loop ends when it is closed."""

    def __init__(self, store: ParameterStore) -> None:
        self.name = store.handle.name.qualified
        self._store = store
        self._stream: AsyncQueue[Parameter] = AsyncQueue(CHANGES_LIMIT)
        store.add_post_set_parameters_callback(self._note)
        store.handle.own(self)

    def _note(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            self._stream.deliver(parameter)

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> tuple[str, Any]:
        """Wait for the next change."""
        parameter = await anext(self._stream)
        return parameter.name, parameter.value

    def close(self) -> None:
        """End the iteration over changes. Idempotent."""
        if self._stream.closed:
            return
        self._stream.close()
        self._store.handle.disown(self)
        self._store.remove_post_set_parameters_callback(self._note)

    destroy = close
