"""The callbacks of a node that run before, while and after parameters are set (rclpy.node).

The one added last is called first. A callback before the set gets the parameters and returns those that are
set instead. A callback on the set may refuse it; nothing has changed by then. A callback after the set gets
the parameters that were set.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol, TypeAlias

from goalwire.errors import CallbackError
from goalwire.rules.parameters.outcome import ACCEPTED, Outcome, refused
from goalwire.rules.parameters.parameter import Parameter


class Verdict(Protocol):
    """The answer of a callback on a set: an rcl_interfaces/msg/SetParametersResult."""

    @property
    def successful(self) -> bool:
        """Whether the parameters may be set."""

    @property
    def reason(self) -> str:
        """Why the change is refused."""


Before: TypeAlias = Callable[[list[Parameter]], Iterable[Parameter]]
On: TypeAlias = Callable[[list[Parameter]], Verdict]
After: TypeAlias = Callable[[list[Parameter]], object]

NOTHING_LEFT = refused(
    'parameter list cannot be empty, this might be due to pre_set_parameters_callback modifying the original '
    'parameters list.'
)


class SetCallbacks:
    """The callbacks of one node, each list in the order of their calls."""

    def __init__(self) -> None:
        self.before: list[Before] = []
        self.on: list[On] = []
        self.after: list[After] = []

    def prepare(self, parameters: list[Parameter]) -> list[Parameter]:
        """Return the parameters to be set instead of `parameters`; raises CallbackError."""
        if not self.before:
            return parameters
        return [wanted for callback in tuple(self.before) for wanted in _choose(callback, parameters)]

    def judge(self, parameters: list[Parameter]) -> Outcome:
        """Ask until one refuses, or returns something else than an answer."""
        for callback in tuple(self.on):
            outcome = _outcome(callback, parameters)
            if not outcome.successful:
                return outcome
        return ACCEPTED

    def tell(self, parameters: list[Parameter]) -> None:
        """Call the callbacks after a set."""
        for callback in tuple(self.after):
            callback(parameters)


def _choose(callback: Before, parameters: list[Parameter]) -> Iterable[Parameter]:
    wanted = callback(parameters)
    if not isinstance(wanted, Sequence):
        raise CallbackError(
            f"the pre-set parameters callback '{_name(callback)}' returned {wanted!r}: "
            'return the list of parameters to set'
        )
    return wanted


def _outcome(callback: On, parameters: list[Parameter]) -> Outcome:
    verdict = callback(parameters)
    try:
        return Outcome(successful=verdict.successful, reason=verdict.reason)
    except AttributeError:
        warnings.warn('Callback returned an invalid type, it should return SetParameterResult.', stacklevel=2)
        return refused(
            f"Callback returned an invalid type: '{_name(callback)}' returned {verdict!r}, "
            'not an rcl_interfaces.msg.SetParametersResult'
        )


def _name(callback: object) -> str:
    return getattr(callback, '__qualname__', None) or repr(callback)
