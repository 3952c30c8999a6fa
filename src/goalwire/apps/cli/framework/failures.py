"""Maps errors to outcomes, and to the one line that a user sees."""

from __future__ import annotations

from pathlib import Path
from traceback import extract_tb

from goalwire import errors
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.observe.progress import ProgressError
from goalwire.tracebacks import is_library

_OUTCOMES: tuple[tuple[type[Exception], Outcome], ...] = (
    (errors.NoServerError, Outcome.NOT_FOUND),
    (errors.NoRobotError, Outcome.NOT_FOUND),
    (errors.DeadlineError, Outcome.TIMEOUT),
    (errors.ServerLostError, Outcome.SERVER_LOST),
    (errors.ServerStuckError, Outcome.SERVER_LOST),
    (errors.ServerFailedError, Outcome.SERVER_LOST),
    (errors.RefusedError, Outcome.REFUSED),
    (errors.GoalAborted, Outcome.ABORTED),
    (errors.GoalCanceled, Outcome.CANCELED),
    (errors.EncodeError, Outcome.BAD_VALUE),
    (errors.InterfaceError, Outcome.NOT_FOUND),
    (errors.TransportError, Outcome.UNAVAILABLE),
    (ProgressError, Outcome.BAD_VALUE),
    (FileNotFoundError, Outcome.NOT_FOUND),
    (TimeoutError, Outcome.TIMEOUT),
)
"""The outcomes of errors; the first class that fits counts."""

_NEXT: tuple[tuple[type[errors.CallError], str], ...] = (
    (errors.NoServerError, 'see: ros2 {kind} list'),
    (errors.DeadlineError, 'give it more time, see --help'),
    (errors.ServerFailedError, "the server's log says why"),
    (errors.ServerLostError, 'see: ros2 {kind} info {name}'),
    (errors.ServerStuckError, 'see: ros2 {kind} info {name}'),
    (errors.RefusedError, 'see: ros2 {kind} info {name}'),
)
"""The advice after a call or goal that did not end well."""


def explain_error(error: Exception) -> tuple[Outcome, str]:
    """Return an error's outcome, and the line that the user sees."""
    while isinstance(error, ExceptionGroup):  # a TaskGroup's first error cancels its other tasks
        error = error.exceptions[0]
    if isinstance(error, CommandError):
        return error.outcome, str(error)
    text = ' '.join(str(error).split()) or type(error).__name__
    for kind, outcome in _OUTCOMES:
        if isinstance(error, kind):
            return outcome, errors.with_advice(text, _next(error, text))
    if isinstance(error, errors.GoalwireError):
        return Outcome.FAILED, text
    if not isinstance(error, OSError):
        text = f'{type(error).__name__}: {text}'
    if advice := _beside_another_rclpy(error):
        return Outcome.FAILED, errors.with_advice(text, advice)
    if isinstance(error, OSError):
        return Outcome.FAILED, text
    text = f'a fault of goalwire itself: {text}; GOALWIRE_FULL_TRACEBACKS=1 shows where'
    return Outcome.FAILED, text


def _beside_another_rclpy(error: Exception) -> str:
    """Return advice for an error in another rclpy, or for a ROS 2 module that cannot be imported."""
    from goalwire.apps.cli.framework.installation import find_rclpy, foreign_rclpy, is_of_ros

    rclpy = foreign_rclpy()
    if rclpy is None or rclpy != find_rclpy():
        return ''
    innermost = [frame.filename for frame in extract_tb(error.__traceback__)][-1:]
    is_theirs = any(Path(file).is_relative_to(rclpy.parent) and not is_library(file) for file in innermost)
    if not is_theirs and not (isinstance(error, ImportError) and is_of_ros(error.name or '')):
        return ''
    return f'this comes from the ROS 2 in {rclpy.parent}: GOALWIRE_FIRST=1 before the command avoids it'


def _next(error: Exception, text: str) -> str:
    """Return advice for the error of a call, whose `text` begins with 'service' or 'action'."""
    if isinstance(error, errors.CallError):
        what = text.partition(' ')[0]
        for kind, advice in _NEXT:
            if isinstance(error, kind) and what in {'service', 'action'}:
                return advice.format(kind=what, name=error.name)
    return ''
