"""The base classes of launch descriptions, and the context in which they are carried out.

Theory of operation. A description is a tree of entities. Visiting an entity does its work and
returns its sub-entities, which are visited depth first: so entities take effect in the order of the file. An
entity that takes time (a process, a timer) returns an asyncio future. Later changes are events: they go
through the context's queue, and each event handler that matches an event returns entities to visit.
`service.py` is the loop that does this until nothing is left to wait for.

The names are those of ROS 2's `launch`, since launch files derive from these classes.
"""

from __future__ import annotations

import asyncio
import os
import sys
from collections import deque
from collections.abc import Callable, Coroutine, Iterable, Iterator, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, TypeAlias

from goalwire.errors import BadLaunchValueError, LaunchError
from goalwire.launching.errors import HERE, OVERLAY, Location, locate


class Event:
    """Something that happened, or a request; event handlers whose `matches` is true handle it."""

    name = 'launch.Event'


class Substitution:
    """A text that is evaluated while the launch runs."""

    def describe(self) -> str:
        """Return a text that shows the substitution unevaluated, for printing."""
        return f'{type(self).__name__}()'

    def perform(self, context: LaunchContext) -> str:
        """Evaluate the substitution, and return its text."""
        raise NotImplementedError

    @classmethod
    def parse(cls, data: Sequence[SomeSubstitutions]) -> tuple[type[Substitution], dict[str, Any]]:
        """Return the class and its keyword arguments for a substitution $(name …) in XML or YAML."""
        if data:
            raise TypeError(f'{cls.__name__} takes no arguments')
        return cls, {}


SomeSubstitutions: TypeAlias = str | Path | Substitution | Iterable[str | Path | Substitution]
"""The types that an argument for a text may have; launch calls them `SomeSubstitutionsType`."""


class Condition:
    """A condition under which an action is carried out."""

    def __init__(self, *, predicate: Callable[[LaunchContext], bool] | None = None) -> None:
        self._predicate = predicate
        self._last: bool | None = None

    def describe(self) -> str:
        return f'{type(self).__name__}({self._predicate})'

    def _condition_expression(self, context: LaunchContext) -> bool:
        return self._predicate is not None and self._predicate(context)

    def evaluate(self, context: LaunchContext) -> bool:
        """Return whether the condition is true, and remember the result."""
        self._last = self._condition_expression(context)
        return self._last

    def evaluate_prev(self) -> bool | None:
        """Return the last result of evaluate(); None before its first call."""
        return self._last


class LaunchDescriptionEntity:
    """A part of a launch description: the base of actions and descriptions."""

    location: Location | None = None

    def describe(self) -> str:
        return repr(self)

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        return []

    def describe_sub_entities(self) -> list[LaunchDescriptionEntity]:
        """Return the sub-entities that are visited unconditionally, for printing."""
        return self.get_sub_entities()

    def describe_conditional_sub_entities(self) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        """Return lists of sub-entities that wait for an event, each with a text that describes the event."""
        return []

    def visit(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity] | None:
        """Do the entity's work, and return the entities to visit next."""
        return None

    def get_asyncio_future(self) -> asyncio.Future[Any] | None:
        """Return a future that is done when the entity's work is; None if the work is done after `visit`."""
        return None

    def find_arguments(self, search: ArgumentSearch) -> Iterator[FoundArgument]:
        """Yield the launch arguments that are declared in the entity and below it, in the file's order."""
        for entity in self.describe_sub_entities():
            yield from entity.find_arguments(search)
        for _, entities in self.describe_conditional_sub_entities():
            for entity in entities:
                yield from entity.find_arguments(search._replace(is_conditional=True))


SomeEntities: TypeAlias = LaunchDescriptionEntity | Iterable[LaunchDescriptionEntity]


class ArgumentSearch(NamedTuple):
    """The state of a search for launch arguments."""

    includes: tuple[LaunchDescriptionEntity, ...] = ()  # the outermost include first
    decided: frozenset[str] = frozenset()  # names set by an include, so no launch arguments
    is_conditional: bool = False


class FoundArgument(NamedTuple):
    """The declaration of a launch argument, and the includes that lead to it."""

    name: str
    declaration: Action
    includes: tuple[LaunchDescriptionEntity, ...]


class Action(LaunchDescriptionEntity):
    """An entity that does its work if its condition holds, or if it has none."""

    def __init__(self, *, condition: Condition | None = None) -> None:
        self._condition = condition
        self.location = _place_outside()

    @property
    def condition(self) -> Condition | None:
        return self._condition

    @classmethod
    def parse(cls, entity: Any, parser: Any) -> tuple[type[Action], dict[str, Any]]:
        """Return the class and its keyword arguments for a tag in XML or YAML: here its `condition`."""
        condition = parser.parse_condition(entity)
        return cls, {} if condition is None else {'condition': condition}

    def describe(self) -> str:
        return f'{type(self).__name__}()'

    def visit(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity] | None:
        if self._condition is not None and not self._condition.evaluate(context):
            return None
        try:
            return self.execute(context)
        finally:
            self._tell_completion(context)

    def execute(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity] | None:
        """Do the action's work, and return the entities to visit next."""
        return None

    def _tell_completion(self, context: LaunchContext) -> None:
        event = ExecutionComplete(action=self)
        future = self.get_asyncio_future()
        if future is not None:
            future.add_done_callback(lambda _: _emit_if_handled(context, event))
        else:
            _emit_if_handled(context, event)


class ExecutionComplete(Event):
    """An action has done its work."""

    name = 'launch.events.ExecutionComplete'

    def __init__(self, *, action: Action) -> None:
        self.action = action


def _emit_if_handled(context: LaunchContext, event: Event) -> None:
    if context.would_handle_event(event):
        context.emit_event_sync(event)


def _place_outside() -> Location | None:
    """Return the launch file's line that constructs an action: the nearest caller outside this package."""
    frame = sys._getframe(1)
    while frame is not None:
        name = frame.f_code.co_filename
        if not name.startswith((HERE, OVERLAY)):
            return Location(name, frame.f_lineno)
        if frame.f_back is None:
            break
        frame = frame.f_back
    return None


class EventHandler:
    """Handles matching events: its entities are then visited."""

    def __init__(
        self,
        *,
        matcher: Callable[[Event], bool],
        entities: SomeEntities | None = None,
        handle_once: bool = False,
    ) -> None:
        self._matcher = matcher
        self._entities = entity_list(entities)
        self._handle_once = handle_once

    @property
    def entities(self) -> list[LaunchDescriptionEntity]:
        return self._entities

    @property
    def handle_once(self) -> bool:
        return self._handle_once

    @property
    def handler_description(self) -> str:
        return '<actions>' if self._entities else f'{type(self).__name__}'

    @property
    def matcher_description(self) -> str:
        return '<matcher>'

    def matches(self, event: Event) -> bool:
        return self._matcher(event)

    def describe(self) -> tuple[str, list[LaunchDescriptionEntity]]:
        """Return a text that describes the handler, and the entities that it would visit."""
        does = f"matcher='{self.matcher_description}', handler='{self.handler_description}'"
        return f'{type(self).__name__}({does})', self._entities

    def handle(self, event: Event, context: LaunchContext) -> SomeEntities | None:
        """Return the entities to visit for an event that matches."""
        context.extend_locals({'event': event})
        if self._handle_once:
            context.unregister_event_handler(self)
        return self._entities


def entity_list(some: Any) -> list[LaunchDescriptionEntity]:
    """Return a list of entities, made from None, one entity or several. Raises LaunchError for others."""
    if some is None:
        return []
    items = [some] if isinstance(some, LaunchDescriptionEntity) else None
    if items is None and isinstance(some, Iterable) and not isinstance(some, str | bytes):
        items = [item for item in some if item is not None]
    if items is None or any(not isinstance(item, LaunchDescriptionEntity) for item in items):
        raise BadLaunchValueError(f'expected actions or other launch entities, got {some!r:.200}')
    return items


class _Locals(SimpleNamespace):
    """A read-only copy of the context's local names: a name that is set here would be lost."""

    def __init__(self, names: dict[str, Any]) -> None:
        self.__dict__.update(names)

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"'{name}' cannot be set here: use extend_locals() of the launch context")


class LaunchContext:
    """The state that entities read and change: launch configurations, environment, handlers, queued events.

    Not thread-safe: other threads use LaunchService.emit_event().
    """

    def __init__(self, *, argv: Iterable[str] | None = None, noninteractive: bool = False) -> None:
        self.argv = list(argv or ())
        self.noninteractive = noninteractive
        self.launch_configurations: dict[str, Any] = {}
        self.is_shutdown = False
        self.running_processes = 0
        self.is_aborted = False  # True after an error: no more processes are started
        self.events: deque[Event] = deque()
        self.handlers: deque[EventHandler] = deque()
        self.completion_futures: set[asyncio.Future[Any]] = set()
        self.cleanups: list[Callable[[], None]] = []  # functions called when the launch has ended, last first
        # Coroutine functions, called and awaited before `cleanups` are called.
        self.async_cleanups: list[Callable[[], Coroutine[Any, Any, None]]] = []
        self.on_failure: Callable[[Exception], None] = lambda _: None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._wake: Callable[[], None] = lambda: None
        self._globals: dict[str, Any] = {}
        self._locals: list[dict[str, Any]] = [{}]
        self._configuration_stack: list[dict[str, Any]] = []
        self._environment_stack: list[dict[str, str]] = []
        self._first_environment = dict(os.environ)

    def attach(self, loop: asyncio.AbstractEventLoop | None, wake: Callable[[], None]) -> None:
        """Set the running loop, and the function that wakes it for a new event."""
        self._loop, self._wake = loop, wake

    @property
    def asyncio_loop(self) -> asyncio.AbstractEventLoop:
        if self._loop is None:
            raise LaunchError('this launch does not run: entities are executed by LaunchService.run()')
        return self._loop

    @property
    def environment(self) -> dict[str, str]:
        """The environment for the processes of the launch: os.environ itself, not a copy."""
        return os.environ  # type: ignore[return-value]

    # --- local and global names

    @property
    def locals(self) -> Any:
        """The local names of the scope, such as `event`, as read-only attributes.

        Raises AttributeError for an unknown name, and if a name is set: extend_locals() sets names.
        """
        return _Locals(self.get_locals_as_dict())

    def get_locals_as_dict(self) -> dict[str, Any]:
        return {**self._globals, **self._locals[-1]}

    def extend_locals(self, extra: dict[str, Any]) -> None:
        self._locals[-1].update(extra)

    def extend_globals(self, extra: dict[str, Any]) -> None:
        self._globals.update(extra)

    def remove_globals(self, names: Iterable[str]) -> None:
        for name in names:
            self._globals.pop(name, None)

    def get_globals(self) -> dict[str, Any]:
        return dict(self._globals)

    def push_locals(self) -> None:
        self._locals.append({})

    def pop_locals(self) -> None:
        self._locals.pop()

    # --- scopes

    def push_launch_configurations(self) -> None:
        self._configuration_stack.append(dict(self.launch_configurations))

    def pop_launch_configurations(self) -> None:
        if not self._configuration_stack:
            raise LaunchError('there is no pushed scope of launch configurations to go back to')
        self.launch_configurations = self._configuration_stack.pop()

    def push_environment(self) -> None:
        self._environment_stack.append(dict(os.environ))

    def pop_environment(self) -> None:
        if not self._environment_stack:
            raise LaunchError('there is no pushed environment to go back to')
        self._set_environment(self._environment_stack.pop())

    def reset_environment(self) -> None:
        """Restore the environment that the launch began with."""
        self._set_environment(self._first_environment)

    def _set_environment(self, wanted: dict[str, str]) -> None:
        for name in os.environ.keys() - wanted.keys():
            del os.environ[name]
        os.environ.update(wanted)

    # --- events

    def register_event_handler(self, event_handler: EventHandler, append: bool = False) -> None:
        """Register a handler. It gets events before all other handlers, or with `append` after them."""
        if append:
            self.handlers.append(event_handler)
        else:
            self.handlers.appendleft(event_handler)

    def unregister_event_handler(self, event_handler: EventHandler) -> None:
        """Unregister a handler. Raises ValueError if it is not registered."""
        self.handlers.remove(event_handler)

    def would_handle_event(self, event: Event) -> bool:
        return any(handler.matches(event) for handler in self.handlers)

    def emit_event_sync(self, event: Event) -> None:
        """Queue an event; only the loop's thread may call this."""
        self.events.append(event)
        self._wake()

    async def emit_event(self, event: Event) -> None:
        self.emit_event_sync(event)

    def add_completion_future(self, future: asyncio.Future[Any]) -> None:
        """Let the launch end only when this future is done, too."""
        self.completion_futures.add(future)
        future.add_done_callback(self._on_completion)

    def _on_completion(self, future: asyncio.Future[Any]) -> None:
        self.completion_futures.discard(future)
        if not future.cancelled() and isinstance(error := future.exception(), Exception):
            self.on_failure(error)
        self._wake()

    def perform_substitution(self, substitution: Substitution) -> str:
        return substitution.perform(self)


class LaunchDescription(LaunchDescriptionEntity):
    """The entities that a launch file returns, in order."""

    def __init__(
        self,
        initial_entities: Iterable[LaunchDescriptionEntity] | None = None,
        *,
        deprecated_reason: str | None = None,
    ) -> None:
        self._entities = list(initial_entities or ())
        self._deprecated_reason = deprecated_reason

    @property
    def entities(self) -> list[LaunchDescriptionEntity]:
        return self._entities

    @property
    def deprecated(self) -> bool:
        return self._deprecated_reason is not None

    @property
    def deprecated_reason(self) -> str | None:
        return self._deprecated_reason

    def add_entity(self, entity: LaunchDescriptionEntity) -> None:
        self._entities.append(entity)

    def add_action(self, action: Action) -> None:
        self.add_entity(action)

    def get_sub_entities(self) -> list[LaunchDescriptionEntity]:
        return entity_list(self._entities)

    def visit(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity] | None:
        if self._deprecated_reason is not None:
            from goalwire.launching.output import get_logger

            get_logger('launch').warning(f'this launch file is deprecated: {self._deprecated_reason}')
        return self.get_sub_entities()

    def get_launch_arguments_with_include_launch_description_actions(
        self, conditional_inclusion: bool = False
    ) -> list[tuple[Any, list[Any] | None]]:
        """Return what get_launch_arguments() returns, each argument with the includes that lead to it."""
        first: dict[str, FoundArgument] = {}
        search = ArgumentSearch(is_conditional=conditional_inclusion)
        for entity in self._entities:
            for found in entity.find_arguments(search):
                first.setdefault(found.name, found)
        return [(found.declaration, list(found.includes) or None) for found in first.values()]

    def get_launch_arguments(self, conditional_inclusion: bool = False) -> list[Any]:
        """The DeclareLaunchArgument actions of this file and those it includes, each name once.

        Left out are includes that cannot be read without a launch, and arguments that an include sets.
        """
        found = self.get_launch_arguments_with_include_launch_description_actions(conditional_inclusion)
        return [argument for argument, _ in found]


def visit_tree(
    entity: LaunchDescriptionEntity, context: LaunchContext
) -> Iterator[tuple[LaunchDescriptionEntity, asyncio.Future[Any]]]:
    """Visit an entity and its sub-entities, depth first; yield each that must be awaited, with its future.

    Raises LaunchError with the failure, and the file and line of the entity that failed.
    """
    try:
        entities = entity_list(entity.visit(context))
    except Exception as error:
        raise locate(error, entity.location) from error
    future = entity.get_asyncio_future()
    if future is not None:
        yield entity, future
    for inner in entities:
        yield from visit_tree(inner, context)
