"""Managed entities: a managed node calls them back at each of its transitions (rclpy.lifecycle)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import wraps
from types import CoroutineType
from typing import Any, Concatenate, ParamSpec, TypeVar, overload

from goalwire.rules.lifecycle import LifecycleState, TransitionCallbackReturnType

P = ParamSpec('P')
T = TypeVar('T')
EntityT = TypeVar('EntityT', bound='SimpleManagedEntity')

_SUCCESS = TransitionCallbackReturnType.SUCCESS


class ManagedEntity:
    """Each callback gets the state from which the transition started. Override those that you need."""

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        """Prepare for work."""
        return _SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        """Release what on_configure made."""
        return _SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        """Release everything: the node ends."""
        return _SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        """Begin to work."""
        return _SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        """Stop working."""
        return _SUCCESS

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        """Recover from the error of another callback: SUCCESS if the node is as good as new."""
        return _SUCCESS


class SimpleManagedEntity(ManagedEntity):
    """An entity that is enabled while its node is active."""

    def __init__(self) -> None:
        self._enabled = False

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        self._enabled = True
        return _SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturnType:  # noqa: ARG002
        self._enabled = False
        return _SUCCESS

    @property
    def is_activated(self) -> bool:
        """True while it is enabled."""
        return self._enabled

    @overload
    @staticmethod
    def when_enabled(
        wrapped: None = None, *, when_not_enabled: Callable[[], object] | None = None
    ) -> Callable[[Callable[Concatenate[EntityT, P], T]], Callable[Concatenate[EntityT, P], T | None]]: ...

    @overload
    @staticmethod
    def when_enabled(
        wrapped: Callable[Concatenate[EntityT, P], T], *, when_not_enabled: Callable[[], object] | None = None
    ) -> Callable[Concatenate[EntityT, P], T | None]: ...

    @staticmethod
    def when_enabled(
        wrapped: Callable[..., Any] | None = None, *, when_not_enabled: Callable[[], object] | None = None
    ) -> Callable[..., Any]:
        """Decorate a method that runs only while its entity is enabled. Else `when_not_enabled` is called, if
        given.
        """

        def decorate(method: Callable[..., Any]) -> Callable[..., Any]:
            @wraps(method)
            def only_when_enabled(self: SimpleManagedEntity, *args: Any, **kwargs: Any) -> Any:
                if self._enabled:
                    return method(self, *args, **kwargs)
                if when_not_enabled is not None:
                    when_not_enabled()
                return None

            return only_when_enabled

        return decorate if wrapped is None else decorate(wrapped)


def call_each(
    entities: Iterable[ManagedEntity], callback: str, state: LifecycleState
) -> TransitionCallbackReturnType:
    """Call back each entity in turn, up to the first that does not say SUCCESS, and return the last answer.

    Raises TypeError for an answer of another type.
    """
    for entity in entities:
        outcome = check_outcome(getattr(entity, callback)(state), f'{type(entity).__name__}.{callback}()')
        if outcome is not _SUCCESS:
            return outcome
    return _SUCCESS


def check_outcome(outcome: object, callback: str) -> TransitionCallbackReturnType:
    """Return the answer of a transition callback; raises TypeError for any other value."""
    if isinstance(outcome, TransitionCallbackReturnType):
        return outcome
    if isinstance(outcome, CoroutineType):
        outcome.close()
        raise TypeError(
            f'{callback} is a coroutine; a transition has no executor to run one: write `def`, and wait '
            'in it with blocking calls'
        )
    raise TypeError(
        f'{callback} returned {outcome!r}; return TransitionCallbackReturn.SUCCESS, FAILURE or ERROR'
    )
