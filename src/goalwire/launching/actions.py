"""The actions of launch that start no process."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable, Iterator, Sequence
from typing import Any

from goalwire.errors import BadLaunchValueError, LaunchError, SubstitutionFailure
from goalwire.launching.events import RunningProcessEvent, TimerEvent
from goalwire.launching.events import Shutdown as ShutdownEvent
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import (
    Action,
    ArgumentSearch,
    Event,
    EventHandler,
    FoundArgument,
    LaunchContext,
    LaunchDescriptionEntity,
    SomeEntities,
    SomeSubstitutions,
    Substitution,
    entity_list,
)
from goalwire.launching.output import get_logger
from goalwire.launching.values import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    truth,
)


@expose_action('arg')
class DeclareLaunchArgument(Action):
    """Declares an argument of the launch file; its value is a launch configuration."""

    def __init__(
        self,
        name: str,
        *,
        default_value: SomeSubstitutions | None = None,
        description: str | None = None,
        choices: Iterable[str] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        if not isinstance(name, str):
            raise TypeError(f'DeclareLaunchArgument expects its name as a string, got {name!r:.100}')
        self._name = name
        self._default = None if default_value is None else normalize_to_list_of_substitutions(default_value)
        self._choices = None if choices is None else list(choices)
        if self._choices == []:
            raise LaunchError(f"argument '{name}' has no choices: leave `choices` out")
        if self._choices and isinstance(default_value, str) and default_value not in self._choices:
            raise LaunchError(
                f"default_value '{default_value}' of argument '{name}' is not in provided choices "
                f'{self._choices}'
            )
        self._description = description or 'no description given'
        if self._choices:
            self._description += f'. Valid choices are: {self._choices}'
        self._conditionally_included = False

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        arguments['name'] = parser.escape_characters(entity.get_attr('name'))
        default = entity.get_attr('default', optional=True)
        if default is not None:
            arguments['default_value'] = parser.parse_substitution(default)
        description = entity.get_attr('description', optional=True)
        if description is not None:
            arguments['description'] = parser.escape_characters(description)
        choices = entity.get_entities('choice')
        if choices:
            arguments['choices'] = [choice.get_attr('value') for choice in choices]
            for choice in choices:
                choice.assert_entity_completely_parsed()
        return cls, arguments

    @property
    def name(self) -> str:
        return self._name

    @property
    def default_value(self) -> list[Substitution] | None:
        return self._default

    @property
    def description(self) -> str:
        return self._description

    @property
    def choices(self) -> list[str] | None:
        return self._choices

    @property
    def conditionally_included(self) -> bool:
        """True if the argument is declared only under a condition, as `find_arguments` has found out."""
        return self._conditionally_included

    def describe(self) -> str:
        return f"DeclareLaunchArgument('{self._name}')"

    def find_arguments(self, search: ArgumentSearch) -> Iterator[FoundArgument]:
        if self._name not in search.decided:
            self._conditionally_included = search.is_conditional or self.condition is not None
            yield FoundArgument(self._name, self, search.includes)

    def execute(self, context: LaunchContext) -> None:
        if self._name not in context.launch_configurations:
            if self._default is None:
                raise LaunchError(
                    f"Required launch argument '{self._name}' was not provided: pass {self._name}:=VALUE"
                )
            context.launch_configurations[self._name] = perform_substitutions(context, self._default)
        value = context.launch_configurations[self._name]
        if self._choices is not None and value not in self._choices:
            raise LaunchError(
                f"argument '{self._name}' provided value '{value}' is not valid; "
                f'valid options are: {self._choices}'
            )


class LogInfo(Action):
    """Logs a message of the launch itself."""

    def __init__(self, *, msg: SomeSubstitutions, level: SomeSubstitutions = 'INFO', **options: Any) -> None:
        super().__init__(**options)
        self._message = normalize_to_list_of_substitutions(msg)
        self._level = normalize_to_list_of_substitutions(level)

    @property
    def msg(self) -> list[Substitution]:
        return self._message

    def describe(self) -> str:
        return f'{type(self).__name__}({describe_text(self._message)})'

    def execute(self, context: LaunchContext) -> None:
        level = perform_substitutions(context, self._level).upper()
        wanted = {'WARN': 'warning', 'FATAL': 'critical'}.get(level, level.lower())
        if wanted not in {'debug', 'info', 'warning', 'error', 'critical'}:
            raise LaunchError(f"there is no log level '{level}': use DEBUG, INFO, WARNING, ERROR or CRITICAL")
        getattr(get_logger('launch.user'), wanted)(perform_substitutions(context, self._message))


@expose_action('log')
class Log(LogInfo):
    """Logs a message of the launch itself, with a level."""

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        arguments['msg'] = parser.parse_substitution(entity.get_attr('message'))
        level = entity.get_attr('level', optional=True)
        if level is not None:
            arguments['level'] = parser.parse_substitution(level)
        return cls, arguments


class EmitEvent(Action):
    """Puts an event into the context's queue."""

    def __init__(self, *, event: Event, **options: Any) -> None:
        super().__init__(**options)
        if not isinstance(event, Event):
            raise TypeError(f'EmitEvent expects an event, got {event!r:.100}')
        self.event = event

    def describe(self) -> str:
        return f'EmitEvent({type(self.event).__name__})'

    def execute(self, context: LaunchContext) -> None:
        context.emit_event_sync(self.event)


@expose_action('shutdown')
class Shutdown(EmitEvent):
    """Ends the launch."""

    def __init__(self, *, reason: SomeSubstitutions = 'reason not given', **options: Any) -> None:
        super().__init__(event=ShutdownEvent(), **options)
        self._reason = normalize_to_list_of_substitutions(reason)

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        reason = entity.get_attr('reason', optional=True)
        if reason is not None:
            arguments['reason'] = parser.parse_substitution(reason)
        return cls, arguments

    def describe(self) -> str:
        return f'Shutdown({describe_text(self._reason)})'

    def execute(self, context: LaunchContext) -> None:
        event = getattr(context.locals, 'event', None)
        reason = perform_substitutions(context, self._reason)
        if isinstance(event, RunningProcessEvent) and reason == 'reason not given':
            reason = f'process[{event.process_name}] was required'
        context.emit_event_sync(ShutdownEvent(reason=reason))


class RegisterEventHandler(Action):
    """Registers an event handler, which handles events from then on."""

    def __init__(self, event_handler: EventHandler, **options: Any) -> None:
        super().__init__(**options)
        if not isinstance(event_handler, EventHandler):
            raise TypeError(f'RegisterEventHandler expects an event handler, got {event_handler!r:.100}')
        self.event_handler = event_handler

    def describe_conditional_sub_entities(self) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        text, entities = self.event_handler.describe()
        return [(text, entities)]

    def execute(self, context: LaunchContext) -> None:
        context.register_event_handler(self.event_handler)


class UnregisterEventHandler(Action):
    """Unregisters an event handler, which then handles no more events."""

    def __init__(self, event_handler: EventHandler, **options: Any) -> None:
        super().__init__(**options)
        self.event_handler = event_handler

    def execute(self, context: LaunchContext) -> None:
        try:
            context.unregister_event_handler(self.event_handler)
        except ValueError:
            raise BadLaunchValueError(
                'UnregisterEventHandler: that event handler is not registered'
            ) from None


class OpaqueFunction(Action):
    """Calls function(context, *args, **kwargs), and visits the entities that the function returns."""

    def __init__(
        self,
        *,
        function: Callable[..., SomeEntities | None],
        args: Iterable[Any] | None = None,
        kwargs: dict[str, Any] | None = None,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        if not callable(function):
            raise TypeError(f'OpaqueFunction expects a function, got {function!r:.100}')
        self._function = function
        self._args = tuple(args or ())
        self._kwargs = dict(kwargs or {})

    def describe(self) -> str:
        return f'OpaqueFunction({getattr(self._function, "__name__", self._function)})'

    def execute(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity]:
        return entity_list(self._function(context, *self._args, **self._kwargs))


class OpaqueCoroutine(Action):
    """Runs coroutine(context, *args, **kwargs) in the launch's loop; the end of the launch cancels it."""

    def __init__(
        self,
        *,
        coroutine: Callable[..., Awaitable[None]],
        args: Iterable[Any] | None = None,
        kwargs: dict[str, Any] | None = None,
        ignore_context: bool = False,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self._coroutine = coroutine
        self._args = tuple(args or ())
        self._kwargs = dict(kwargs or {})
        self._ignore_context = ignore_context
        self._task: asyncio.Future[None] | None = None

    def execute(self, context: LaunchContext) -> None:
        args = self._args if self._ignore_context else (context, *self._args)
        task = asyncio.ensure_future(self._coroutine(*args, **self._kwargs), loop=context.asyncio_loop)
        handler = EventHandler(
            matcher=lambda event: isinstance(event, ShutdownEvent),
            entities=OpaqueFunction(function=lambda _: (task.cancel(), None)[1]),
            handle_once=True,
        )
        context.register_event_handler(handler)
        self._task = task

    def get_asyncio_future(self) -> asyncio.Future[None] | None:
        return self._task


@expose_action('timer')
class TimerAction(Action):
    """Visits actions once, after `period` seconds. Cancelling the timer, or a shutdown, prevents this."""

    def __init__(
        self,
        *,
        period: float | SomeSubstitutions,
        actions: Iterable[LaunchDescriptionEntity],
        cancel_on_shutdown: bool | SomeSubstitutions = True,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        self._given_period = float(period) if isinstance(period, int | float) else None
        self._period = normalize_to_list_of_substitutions(
            str(period) if isinstance(period, int | float) else period
        )
        self._actions = list(actions)
        self._cancel_on_shutdown = cancel_on_shutdown
        self._timer: asyncio.TimerHandle | None = None
        self._done: asyncio.Future[None] | None = None
        self._canceled = False
        self._locals: dict[str, Any] = {}

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        period = entity.get_attr('period', data_type=float)
        arguments['period'] = parser.parse_if_substitutions(period)
        arguments['actions'] = parser.parse_children(entity)
        return cls, arguments

    @property
    def period(self) -> float | list[Substitution]:
        """The timer's period in seconds, or the substitutions that will give it."""
        return self._period if self._given_period is None else self._given_period

    @property
    def actions(self) -> list[LaunchDescriptionEntity]:
        return self._actions

    def describe(self) -> str:
        return f'{type(self).__name__}(period={describe_text(self._period)})'

    def describe_conditional_sub_entities(self) -> list[tuple[str, Iterable[LaunchDescriptionEntity]]]:
        return [(f'{describe_text(self._period)} seconds pass without being canceled', self._actions)]

    def seconds(self, context: LaunchContext) -> float:
        """Return the evaluated period in seconds. Raises LaunchError if it is not a number of seconds."""
        text = perform_substitutions(context, self._period)
        try:
            seconds = float(text)
        except ValueError:
            seconds = -1.0
        if not 0 <= seconds < float('inf'):
            raise LaunchError(f"a timer's period is a number of seconds, not '{text}'")
        return seconds

    def execute(self, context: LaunchContext) -> None:
        done: asyncio.Future[None] = context.asyncio_loop.create_future()
        self._done = done
        if self._canceled:
            done.set_result(None)
            return
        self._locals = context.get_locals_as_dict()
        handler = EventHandler(
            matcher=lambda event: isinstance(event, TimerEvent) and event.timer_action is self,
            entities=OpaqueFunction(function=self._fire),
            handle_once=True,
        )
        context.register_event_handler(handler)
        self._start(context, self.seconds(context))
        if _flag(context, self._cancel_on_shutdown):
            context.register_event_handler(
                EventHandler(
                    matcher=lambda event: isinstance(event, ShutdownEvent),
                    entities=OpaqueFunction(function=lambda _: self.cancel()),
                    handle_once=True,
                )
            )

    def _start(self, context: LaunchContext, seconds: float) -> None:
        self._timer = context.asyncio_loop.call_later(seconds, self.expire, context)

    def expire(self, context: LaunchContext) -> None:
        """Emit the timer's event, unless the timer has fired or was cancelled."""
        if self._done is not None and not self._done.done():
            context.emit_event_sync(TimerEvent(timer_action=self))

    def _fire(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        if self._done is not None and not self._done.done():
            self._done.set_result(None)
        if self._canceled:
            return []
        context.extend_locals(self._locals)
        return self._actions

    def cancel(self) -> None:
        """Cancel the timer. Do nothing if it has fired or never started."""
        self._canceled = True
        if self._timer is not None:
            self._timer.cancel()
        if self._done is not None and not self._done.done():
            self._done.set_result(None)

    def get_asyncio_future(self) -> asyncio.Future[None] | None:
        return self._done


def _flag(context: LaunchContext, some: bool | SomeSubstitutions) -> bool:
    """Return a boolean, or a text such as true as one. Raises SubstitutionFailure for other texts."""
    if isinstance(some, bool):
        return some
    return truth(context, some)


class ForLoop(Action):
    """Visits the entities of function(i), for each i below `length`."""

    def __init__(
        self, length: SomeSubstitutions, *, function: Callable[[int], SomeEntities | None], **options: Any
    ) -> None:
        super().__init__(**options)
        self._length = normalize_to_list_of_substitutions(length)
        self._function = function

    def execute(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity]:
        text = perform_substitutions(context, self._length)
        try:
            length = int(text)
        except ValueError:
            raise SubstitutionFailure(f"a loop's length is a whole number, not '{text}'") from None
        return [entity for index in range(length) for entity in entity_list(self._function(index))]


class ForEach(Action):
    """Visits the entities of function(**values), for each of the YAML mappings in a text: `{a: 1};{a: 2}`."""

    def __init__(
        self, input_values: SomeSubstitutions, *, function: Callable[..., SomeEntities | None], **options: Any
    ) -> None:
        super().__init__(**options)
        self._values = normalize_to_list_of_substitutions(input_values)
        self._function = function

    def execute(self, context: LaunchContext) -> Sequence[LaunchDescriptionEntity]:
        import yaml

        text = perform_substitutions(context, self._values)
        rounds = [yaml.safe_load(part) for part in text.split(';') if part.strip()]
        if not all(isinstance(item, dict) for item in rounds):
            raise SubstitutionFailure(f"expected YAML mappings separated by semicolons, got '{text}'")
        return [entity for values in rounds for entity in entity_list(self._function(**values))]
