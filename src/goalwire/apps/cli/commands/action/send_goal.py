"""ros2 action send_goal: sends a goal and waits until it ends; Ctrl-C cancels the goal."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING, Any
from uuid import UUID

import goalwire
from goalwire.apps.cli.commands.action.display import RunDisplay, progress_argument, yaml_text
from goalwire.apps.cli.commands.action.known_goals import refuse_unclear
from goalwire.apps.cli.commands.service.call import LOOK_S, PATIENCE_S
from goalwire.apps.cli.framework import lookup, values
from goalwire.apps.cli.framework.entity_kinds import ACTIONS
from goalwire.apps.cli.framework.live import live, refuse_other_type, tell_types_ourselves, types_there
from goalwire.apps.cli.framework.numbers import positive
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.graph.names import SEND_GOAL, show_type
from goalwire.observe.progress import ProgressError
from goalwire.transport.contract import EndpointKind

if TYPE_CHECKING:
    from goalwire.apps.cli.framework.output import Output

CANCEL_S = 30.0
"""Seconds that a server may take to accept a cancel request after Ctrl-C; a second Ctrl-C ends the wait."""


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `action send_goal`."""
    ACTIONS.name_argument(parser)
    parser.add_argument(
        'words',
        nargs='*',
        metavar='[TYPE] [GOAL]',
        help=f'Type of the action, which may be left out if the graph knows it; then {values.HELP}',
    )
    parser.add_argument('--stdin', action='store_true', help='Read the goal from standard input')
    parser.add_argument('--goal-file', metavar='FILE', help='Read the goal from a YAML file')
    parser.add_argument('-f', '--feedback', action='store_true', help='Echo the feedback of the goal')
    progress_argument(parser)
    parser.add_argument(
        '--detach',
        action='store_true',
        help="Print only the goal's id when the goal is accepted, and exit while it runs; "
        'see `action attach` and `action probe`',
    )
    parser.add_argument(
        '--goal-id',
        metavar='ID',
        type=_goal_id,
        help='Id of the goal, a UUID. If the server has a goal of this id, that goal is followed, '
        'and nothing is sent',
    )
    parser.add_argument(
        '-t',
        '--timeout',
        metavar='S',
        type=positive,
        help='Seconds that the goal may take, the wait for the server included; then it is cancelled. '
        f'Without, the server must appear within {PATIENCE_S:.0f} s, and the goal may take any time',
    )


def _goal_id(text: str) -> bytes:
    try:
        goal_id = UUID(text).bytes
    except ValueError:
        raise ArgumentTypeError(f"'{text}' is not a UUID, which has 32 hexadecimal digits") from None
    if not any(goal_id):
        raise ArgumentTypeError(f"'{text}' is not an id of a goal: in a request to cancel it means all")
    return goal_id


class _Goal:
    """One goal and how it is shown."""

    def __init__(self, arguments: Namespace, output: Output) -> None:
        """Read the command line; raises CommandError."""
        self._arguments = arguments
        self._output = output
        self._name = lookup.full_name(arguments.action_name, 'action')
        type_name, words = lookup.split_type(arguments.words, 'action')
        if type_name is None:
            self._name, type_name = ACTIONS.name_and_type(arguments)
        self._type_name = type_name
        self._cls = lookup.interface_in_use(type_name)
        self._display = RunDisplay(output, feedback=arguments.feedback, progress=arguments.progress)
        if arguments.goal_file:
            words = [f'@{arguments.goal_file}']
        given = values.read_values(words, self._cls.Goal, stdin=arguments.stdin)
        self._goal = self._cls.Goal()
        self._set_stamps = values.fill(self._goal, given, type_name)

    async def perform(self, node: goalwire.Node) -> Outcome:
        """Send the goal, show its feedback and its result, and return the outcome."""
        tell_types_ourselves()
        client = node.action(self._cls, self._name)
        self._say('Waiting for an action server to become available...')
        try:
            await client.wait_for_server(timeout=LOOK_S)
        except goalwire.NoServerError:
            types = types_there(node, EndpointKind.SERVICE, self._name + SEND_GOAL)
            refuse_other_type(self._name, self._type_name, [show_type(each) for each in types])
            await client.wait_for_server(timeout=self._arguments.timeout or PATIENCE_S)
        known = await self._follow_known(client, node)
        if known is not None:
            return known
        for set_stamp in self._set_stamps:
            set_stamp(node.clock.now().to_msg())
        self._say(f'Sending goal:\n     {yaml_text(self._goal)}')
        # Without `grace`, the end of the block does not wait for the goal: `_cancel` cancels it and waits.
        sending = client.send(
            self._goal,
            timeout=self._arguments.timeout,
            grace=0.0,
            goal_id=self._arguments.goal_id,
            keep=self._arguments.detach,
        )
        try:
            async with sending as run:
                self._tell_accepted(run)
                return Outcome.OK if self._arguments.detach else await self._follow(run, node)
        except goalwire.GoalRefused:
            if self._output.json:
                self._output.data({'event': 'rejected'})
            if self._arguments.detach:
                raise
            self._say('Goal was rejected.')
            return Outcome.REFUSED

    async def _follow_known(
        self, client: goalwire.ActionClient[Any, Any, Any], node: goalwire.Node
    ) -> Outcome | None:
        """Follow the goal of the id that was given, if the server has it. Return None if it has not.

        The server is asked before anything is sent: an id that a server of rclcpp knows would end it.
        """
        goal_id = self._arguments.goal_id
        if goal_id is None:
            return None
        found = await client.probe(goal_id)
        refuse_unclear(found)
        if found.state is goalwire.GoalState.UNKNOWN:
            return None
        if self._output.json:
            self._output.data({'event': 'known', 'goal_id': goal_id.hex()})
        if self._arguments.detach:
            if not self._output.json:
                self._output.line(goal_id.hex())
            return Outcome.OK
        self._say(f'The server has the goal {goal_id.hex()}: nothing is sent\n')
        if found.state is not goalwire.GoalState.RUNNING:
            return self._display.show_ended(found, self._cls.Result)
        async with client.attach(goal_id, timeout=self._arguments.timeout) as run:
            return await self._follow(run, node)

    def _tell_accepted(self, run: goalwire.Run[Any, Any]) -> None:
        if self._output.json:
            self._output.data({'event': 'accepted', 'goal_id': run.goal_id.hex()})
        elif self._arguments.detach:
            self._output.line(run.goal_id.hex())
        self._say(f'Goal accepted with ID: {run.goal_id.hex()}\n')

    async def _follow(self, run: goalwire.Run[Any, Any], node: goalwire.Node) -> Outcome:
        try:
            return await self._display.follow(run)
        except ProgressError:
            # The feedback lacks the field for --progress. The `async with` in `perform` cancels the goal.
            node.logger.set_level(50)
            raise
        except (asyncio.CancelledError, goalwire.DeadlineError) as error:
            # Silence the log, because the command itself now prints what happens to the goal.
            node.logger.set_level(50)
            return await self._cancel(run, error)

    async def _cancel(self, run: goalwire.Run[Any, Any], why: BaseException) -> Outcome:
        """Cancel the goal after Ctrl-C or the deadline, then wait until it ends or Ctrl-C comes again."""
        task = asyncio.current_task()
        assert task is not None
        self._display.clear_bar()
        self._say('Canceling goal...')
        is_late = isinstance(why, goalwire.DeadlineError)
        try:
            await self._ask_to_cancel(run, PATIENCE_S if is_late else CANCEL_S)
            outcome = await self._end(run, PATIENCE_S if is_late else None)
        except asyncio.CancelledError:
            tell(f'left without waiting, the goal may go on; see: ros2 action goals {self._name}')
            raise
        if is_late:
            raise why
        return outcome

    async def _ask_to_cancel(self, run: goalwire.Run[Any, Any], patience: float) -> None:
        """Request the cancellation; raises CommandError if the server refuses it or does not answer."""
        see = f'see: ros2 action goals {self._name}'
        try:
            accepted = await run.cancel(timeout=patience)
        except goalwire.DeadlineError:
            problem = (
                f'the server did not answer the cancel request within {patience:.0f} s; the goal may go on'
            )
            raise CommandError(Outcome.TIMEOUT, problem, see) from None
        if not accepted:
            raise CommandError(Outcome.REFUSED, 'the server does not cancel the goal, which goes on', see)

    async def _end(self, run: goalwire.Run[Any, Any], patience: float | None) -> Outcome:
        """Wait for the cancelled goal's end: `patience` s from now, or with None until its deadline."""
        try:
            return await self._display.show_end(run, by_ourselves=True, patience=patience)
        except goalwire.DeadlineError:
            self._say('The server cancels the goal, which has not ended yet.')
            return Outcome.TIMEOUT  # The command ends without the result.

    def _say(self, text: str) -> None:
        if not self._arguments.detach:
            self._display.say(text)


def run(arguments: Namespace, output: Output) -> Outcome:
    """Send a goal; raises CommandError and goalwire's own errors."""
    goal = _Goal(arguments, output)
    return live(goal.perform)
