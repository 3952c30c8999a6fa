"""Event handlers for the end of actions and of the launch; `process_handlers.py` has those for processes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from goalwire.errors import LaunchError
from goalwire.launching.events import IncludeLaunchDescription, Shutdown
from goalwire.launching.model import (
    Action,
    Event,
    EventHandler,
    ExecutionComplete,
    LaunchContext,
    LaunchDescriptionEntity,
    SomeEntities,
    entity_list,
)

Answer: TypeAlias = SomeEntities | Callable[..., SomeEntities | None] | None
Target: TypeAlias = Callable[[Any], bool] | LaunchDescriptionEntity | None


class OnActionEventBase(EventHandler):
    """Handles events of one class: those of one action, of the actions that match, or of all actions."""

    def __init__(
        self,
        *,
        action_matcher: Target,
        on_event: Answer,
        target_event_cls: type[Event],
        target_action_cls: type[LaunchDescriptionEntity] = Action,
        **options: Any,
    ) -> None:
        if isinstance(action_matcher, LaunchDescriptionEntity):
            if not isinstance(action_matcher, target_action_cls):
                raise TypeError(
                    f'{type(self).__name__} expects a target of type {target_action_cls.__name__}, '
                    f'got {type(action_matcher).__name__}'
                )
        elif action_matcher is not None and not callable(action_matcher):
            raise TypeError(
                f'{type(self).__name__} expects an action or a function, got {action_matcher!r:.100}'
            )
        self._target = action_matcher
        self._event_class = target_event_cls
        self._answer = on_event if callable(on_event) else None
        super().__init__(
            matcher=self._is_meant,
            entities=None if callable(on_event) else on_event,
            **options,
        )

    def _is_meant(self, event: Event) -> bool:
        if not isinstance(event, self._event_class):
            return False
        action = getattr(event, 'action', None)
        if self._target is None:
            return True
        if callable(self._target):
            return bool(self._target(action))
        return action is self._target

    @property
    def matcher_description(self) -> str:
        target = _target_text(self._target)
        return f'event == {self._event_class.__name__} and event.action == {target}'

    def handle(self, event: Event, context: LaunchContext) -> SomeEntities | None:
        entities = super().handle(event, context)
        return entities if self._answer is None else self._answer(event, context)


def _target_text(target: Target) -> str:
    if target is None:
        return 'any action'
    if isinstance(target, LaunchDescriptionEntity):
        return target.describe()
    return getattr(target, '__name__', 'one that matches')


class OnExecutionComplete(OnActionEventBase):
    """Handles the end of an action."""

    def __init__(self, *, target_action: Target = None, on_completion: Answer = None, **options: Any) -> None:
        super().__init__(
            action_matcher=target_action,
            on_event=on_completion,
            target_event_cls=ExecutionComplete,
            **options,
        )


class OnShutdown(EventHandler):
    """Handles the shutdown of the launch, while its processes still run."""

    def __init__(self, *, on_shutdown: Answer = None, **options: Any) -> None:
        self._answer = on_shutdown if callable(on_shutdown) else None
        self._given = None if callable(on_shutdown) else on_shutdown
        if on_shutdown is not None and self._answer is None:
            entity_list(on_shutdown)
        super().__init__(
            matcher=lambda event: isinstance(event, Shutdown),
            entities=None if self._answer else on_shutdown,  # type: ignore[arg-type]
            **options,
        )

    @property
    def matcher_description(self) -> str:
        return 'event is Shutdown'

    def handle(self, event: Event, context: LaunchContext) -> SomeEntities | None:
        super().handle(event, context)
        return self._given if self._answer is None else self._answer(event, context)


class OnIncludeLaunchDescription(EventHandler):
    """Carries out a description that was passed to LaunchService.include_launch_description()."""

    def __init__(self, **options: Any) -> None:
        super().__init__(matcher=lambda event: isinstance(event, IncludeLaunchDescription), **options)

    def handle(self, event: Event, context: LaunchContext) -> SomeEntities | None:
        super().handle(event, context)
        if not isinstance(event, IncludeLaunchDescription):
            raise LaunchError('OnIncludeLaunchDescription handles only IncludeLaunchDescription')
        return event.launch_description
