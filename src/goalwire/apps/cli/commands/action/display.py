"""How a goal is shown: its feedback, its result, and a bar for its progress."""

from __future__ import annotations

from argparse import ArgumentParser
from typing import TYPE_CHECKING, Any

import goalwire
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.observe.messages import as_dict
from goalwire.observe.progress import Progress

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output


_WIDTH = 30


def progress_argument(parser: ArgumentParser, more_help: str = '') -> None:
    """Add `--progress`."""
    parser.add_argument(
        '--progress',
        metavar='FIELD[/MAX]',
        help='Draw a bar on a terminal from a field of the feedback: a part of 1, or of MAX as in FIELD/MAX; '
        'of an array its length counts. A field that says what remains begins at nothing done' + more_help,
    )


def check_field(spec: str | None) -> None:
    """Raise ProgressError if `--progress` cannot be read, before anything is sent."""
    if spec:
        Progress(spec)


def bar(done: float) -> str:
    """Return a progress bar for a terminal; `done` goes from 0 to 1."""
    full = round(done * _WIDTH)
    return f'{"█" * full}{"░" * (_WIDTH - full)} {done * 100:3.0f} %'


_OUTCOMES = {'SUCCEEDED': Outcome.OK, 'ABORTED': Outcome.ABORTED, 'CANCELED': Outcome.CANCELED}


class RunDisplay:
    """Prints what happens to one goal: text for people, or with `--json` one document for each event."""

    def __init__(self, output: Output, *, feedback: bool, progress: str | None) -> None:
        """`feedback` prints the feedback as text; `progress` is the feedback field that the bar shows."""
        self._output = output
        self._has_feedback = feedback
        self._progress = Progress(progress) if progress else None
        self._bar = ''

    async def follow(self, run: goalwire.Run[Any, Any]) -> Outcome:
        """Show the feedback until the goal ends, then the goal's result; raises the errors of `run.result`.

        Raises ProgressError if the feedback lacks the field that `--progress` names.
        """
        async for feedback in run.feedback:
            self._show_feedback(feedback)
        return await self.show_end(run)

    async def show_end(
        self, run: goalwire.Run[Any, Any], *, by_ourselves: bool = False, patience: float | None = None
    ) -> Outcome:
        """Wait for the result and show it; `by_ourselves` is True if this command cancelled the goal.

        With `patience` the wait may take so many seconds from now, also beyond the goal's deadline.
        """
        try:
            return self._finish('SUCCEEDED', await run.wait(timeout=patience))
        except goalwire.GoalAborted as error:
            return self._finish('ABORTED', error.result)
        except goalwire.GoalCanceled as error:
            return self._finish('CANCELED', error.result, by_ourselves=by_ourselves)

    def show_ended(self, found: goalwire.GoalProbe[Any], result_type: type) -> Outcome:
        """Show the result of a goal that had ended before; an empty one if its server has forgotten it."""
        result = result_type() if found.result is None else found.result
        return self._finish(found.status.name, result)

    def _show_feedback(self, feedback: Any) -> None:
        if self._output.json:
            self._output.data({'event': 'feedback', 'feedback': as_dict(feedback)})
            return
        self.clear_bar()
        if self._has_feedback:
            self.say(f'Feedback:\n    {yaml_text(feedback)}')
        if self._progress is not None:
            done = self._progress.read(feedback)
            if self._output.is_terminal and done is not None:
                self._bar = bar(done)
                self._output.rewrite(self._bar)

    def _finish(self, status: str, result: Any, *, by_ourselves: bool = False) -> Outcome:
        self.clear_bar()
        if self._output.json:
            self._output.data({'event': 'result', 'status': status, 'result': as_dict(result)})
        self.say(f'Result:\n    {yaml_text(result)}')
        self.say('Goal canceled.' if by_ourselves else f'Goal finished with status: {status}')
        return _OUTCOMES[status]

    def clear_bar(self) -> None:
        """Erase the bar, so that a line can be printed in its place."""
        if self._bar:
            self._bar = ''
            self._output.rewrite('')

    def say(self, text: str) -> None:
        """Print a text for people."""
        if not self._output.json:
            self._output.block(text)


def yaml_text(message: Any) -> str:
    """Return a message as `ros2 action` prints it."""
    from rosidl_runtime_py import message_to_yaml

    return message_to_yaml(message)
