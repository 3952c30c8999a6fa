"""The callbacks of a node that run before, while and after parameters are set (rclpy.node).

Of each kind, the callback that was added last is called first. A pre-set callback gets the parameters, and
returns the parameters to be set in their place. An on-set callback may refuse the change before any value
changes. A post-set callback gets the parameters that were set.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol, TypeAlias

from goalwire.errors import CallbackError
from goalwire.places import function_place
from goalwire.rules.parameters.outcome import ACCEPTED, Outcome, refuse
from goalwire.rules.parameters.parameter import Parameter


class Verdict(Protocol):
    """The answer of an on-set callback: an rcl_interfaces/msg/SetParametersResult."""

    @property
    def successful(self) -> bool:
        """True if the parameters may be set."""

    @property
    def reason(self) -> str:
        """The reason of a refusal."""


Before: TypeAlias = Callable[[list[Parameter]], Iterable[Parameter]]
On: TypeAlias = Callable[[list[Parameter]], Verdict]
After: TypeAlias = Callable[[list[Parameter]], object]

NOTHING_LEFT = refuse(
    'parameter list cannot be empty, this might be due to pre_set_parameters_callback modifying the original '
    'parameters list.'
)


NO_ANSWER = 'Callback returned an invalid type'
"""The beginning of the reason if a callback returned anything but a SetParametersResult."""


class SetCallbacks:
    """The callbacks of one node for setting parameters: three lists, each in the order of the calls."""

    def __init__(self) -> None:
        self.before: list[Before] = []
        self.on: list[On] = []
        self.after: list[After] = []

    def prepare(self, parameters: list[Parameter]) -> list[Parameter]:
        """Return the parameters that pre-set callbacks put in place of `parameters`; raises CallbackError."""
        if not self.before:
            return parameters
        return [wanted for callback in tuple(self.before) for wanted in _choose(callback, parameters)]

    def judge(self, parameters: list[Parameter]) -> Outcome:
        """Call the on-set callbacks until one of them refuses or does not return a SetParametersResult."""
        for callback in tuple(self.on):
            outcome = _outcome(callback, parameters)
            if not outcome.successful:
                return outcome
        return ACCEPTED

    def tell(self, parameters: list[Parameter]) -> None:
        """Call the post-set callbacks with the parameters that were set."""
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
        _tell_no_answer(callback, verdict)
        return refuse(
            f"{NO_ANSWER}: '{_name(callback)}' returned {verdict!r}, "
            'not an rcl_interfaces.msg.SetParametersResult'
        )


def _tell_no_answer(callback: On, verdict: object) -> None:
    """Warn of an on-set callback that returned no SetParametersResult, at the line where it is defined."""
    text = (
        f'{NO_ANSWER}: {_name(callback)}() returned {verdict!r}, so nothing is set; '
        "write 'return SetParametersResult(successful=True)', from rcl_interfaces.msg"
    )
    place = function_place(callback)
    if place:
        file, _, line = place.rpartition(':')
        warnings.warn_explicit(text, UserWarning, file, int(line))
    else:
        warnings.warn(text, stacklevel=3)


def _name(callback: object) -> str:
    return getattr(callback, '__qualname__', None) or repr(callback)
