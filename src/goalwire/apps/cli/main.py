"""The entry point of `goalwire` and `ros2`: finds noun and verb, runs them, and returns the exit code."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from goalwire.apps.cli.framework.interrupts import end_at_once
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.files import discard_output

if TYPE_CHECKING:
    from argparse import Namespace

    from goalwire.apps.cli.framework.output import Output
    from goalwire.apps.cli.framework.verbs import Noun, Verb

FULL_TRACEBACKS = 'GOALWIRE_FULL_TRACEBACKS'


def main() -> int:
    """Run the program's command line, and return the exit code of the process."""
    end_at_once()
    _open_closed_streams()
    program = os.path.splitext(os.path.basename(sys.argv[0]))[0]
    if program not in {'ros2', 'goalwire'}:
        program = 'goalwire'  # python -m goalwire
    if program == 'ros2' and os.environ.get('AMENT_PREFIX_PATH'):
        from goalwire.apps.cli.framework.handover import hand_over

        hand_over(sys.argv)
    code = run_command(program, sys.argv[1:])
    _drop_unwritable_output()
    return code


def _open_closed_streams() -> None:
    """Give a command that is started without standard output or error, as by `>&-`, a place to write to."""
    for name in ('stdout', 'stderr'):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, 'w', encoding='utf-8'))  # noqa: SIM115 - for the whole process


def _drop_unwritable_output() -> None:
    """Drop what cannot be written, to a full disk. Python would try again at its exit, and end with 120."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            discard_output(stream.fileno())


def run_command(program: str, arguments: Sequence[str]) -> int:
    """Run one command line. Any error is one line on standard error, with advice."""
    try:
        try:
            outcome = _dispatch(program, list(arguments))
        except SystemExit as end:  # argparse exits after a help text
            outcome = Outcome(end.code if isinstance(end.code, int) else 0)
        _flush_output(outcome)
    except BrokenPipeError:
        outcome = _close_stdout()
    except KeyboardInterrupt:
        outcome = Outcome.INTERRUPTED
    except Exception as error:
        outcome = _close_stdout() if _is_closed_pipe(error) else _report(program, error)
    return int(outcome)


def _flush_output(outcome: Outcome) -> None:
    """Write what is left. Raises OSError for a full disk, unless the command has another outcome to tell."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError:
        if outcome is Outcome.OK:
            raise


def _dispatch(program: str, arguments: list[str]) -> Outcome:
    if arguments[:1] == ['_complete']:  # called by a shell's completion script
        from goalwire.apps.cli.framework.completion import completions

        print('\n'.join(completions(arguments[1] if arguments[1:] else '', arguments[2:])))  # noqa: T201
        return Outcome.OK
    name, arguments = _noun_name(program, arguments)
    from goalwire.apps.cli.framework.nouns import load

    return _run_noun(program, load(name), arguments)


def _noun_name(program: str, arguments: list[str]) -> tuple[str, list[str]]:
    """Return the noun and the words after it; print the help or the version and exit if asked for."""
    from goalwire.apps.cli.framework.nouns import NOUNS

    while (
        arguments and arguments[0] == '--use-python-default-buffering'
    ):  # a flag of ROS 2, without effect here
        arguments = arguments[1:]
    if not arguments or arguments[0] in {'-h', '--help'}:
        print(_help(program))  # noqa: T201
        raise SystemExit(0)
    if arguments[0] == '--version':
        arguments = ['version', *arguments[1:]]
    name, *rest = arguments
    if name in NOUNS:
        return name, rest
    from goalwire.apps.cli.framework import missing_commands
    from goalwire.apps.cli.framework.verbs import did_you_mean

    if name in missing_commands.ALIASES:
        return missing_commands.ALIASES[name], rest
    if name in missing_commands.NOUNS:
        if (name, *rest[:1]) in missing_commands.HARMLESS:
            print(missing_commands.NOUNS[name])  # noqa: T201
            raise SystemExit(0)
        raise CommandError(
            Outcome.USAGE, f"{program}: there is no command '{name}'", missing_commands.NOUNS[name]
        )
    what = 'flag' if name.startswith('-') else 'command'
    near = did_you_mean(name, ['--help', '--version'] if what == 'flag' else list(NOUNS))
    raise CommandError(
        Outcome.USAGE, f"{program}: there is no {what} '{name}'", f'{near} see: {program} --help'.lstrip()
    )


def _help(program: str) -> str:
    from goalwire.apps.cli.framework.nouns import NOUNS

    width = max(map(len, NOUNS))
    nouns = '\n'.join(f'  {name:{width}}  {summary}' for name, (_, summary) in NOUNS.items())
    return (
        f'usage: {program} [-h] [--version] [--use-python-default-buffering] <command> ...\n\n'
        f"{program} is an extensible command-line tool for ROS 2; this one is goalwire's.\n\n"
        'options:\n'
        '  -h, --help            show this help message and exit\n'
        '  --version             show which version this is\n'
        '  --use-python-default-buffering\n'
        '                        accepted as in ROS 2; output is never held back here\n\n'
        f'Commands:\n{nouns}\n\n'
        f'  Call `{program} <command> -h` for more detailed usage.'
    )


def _run_noun(program: str, noun: Noun, arguments: list[str]) -> Outcome:
    from goalwire.apps.cli.framework.verbs import noun_parser

    if noun.is_command:
        return _run_verb(program, noun, noun.verbs[0], arguments, None)
    flags = []
    while arguments and arguments[0].startswith('-'):
        flags.append(arguments.pop(0))
    parser = noun_parser(program, noun)
    values = parser.parse_args(flags)
    if not arguments:
        parser.print_help()
        raise SystemExit(0)
    verbs = {verb.name: verb for verb in noun.verbs}
    name = arguments.pop(0)
    if name not in verbs:
        from goalwire.apps.cli.framework import missing_commands
        from goalwire.apps.cli.framework.verbs import did_you_mean

        near = missing_commands.VERBS.get((noun.name, name)) or did_you_mean(name, list(verbs))
        raise CommandError(
            Outcome.USAGE,
            f"{parser.prog}: there is no verb '{name}'",
            f'{near} see: {parser.prog} --help'.lstrip(),
        )
    return _run_verb(program, noun, verbs[name], arguments, values)


def _run_verb(
    program: str, noun: Noun, verb: Verb, arguments: list[str], values: Namespace | None
) -> Outcome:
    from goalwire.apps.cli.framework.output import Output
    from goalwire.apps.cli.framework.robots import choose_robot
    from goalwire.apps.cli.framework.verbs import verb_parser

    parser = verb_parser(program, noun, verb)
    if verb.takes_ros_arguments:
        own = arguments
    else:
        own, for_node = _split_ros_arguments(arguments)
        # Without this the node would read a value such as `rate:=fast` as a remapping rule.
        sys.argv[1:] = for_node
    parsed = parser.parse_args(own, values)
    parsed.prog = parser.prog
    choose_robot(parsed)
    output: Output = Output(json=getattr(parsed, 'json', False))
    outcome = verb.run(parsed, output)
    return Outcome.OK if outcome is None else outcome


def _split_ros_arguments(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Return the command's own arguments, and those from `--ros-args` to `--` for its node."""
    own: list[str] = []
    for_node: list[str] = []
    is_ros = False
    for argument in arguments:
        is_ros = is_ros or argument == '--ros-args'
        (for_node if is_ros else own).append(argument)
        is_ros = is_ros and argument != '--'
    return own, for_node


def _report(program: str, error: Exception) -> Outcome:
    """Print an error in one line, and return its exit code."""
    from goalwire.apps.cli.framework.failures import explain_error
    from goalwire.errors import peer_text

    outcome, text = explain_error(error)
    if not text.startswith(program):
        text = f'{program}: {text}'
    if os.environ.get(FULL_TRACEBACKS) == '1':
        import traceback

        traceback.print_exception(error)
    with suppress(OSError):  # the disk is full, where standard error goes
        print(peer_text(text, 2000), file=sys.stderr)  # noqa: T201
    try:
        _flush_output(outcome)
    except BrokenPipeError:
        _close_stdout()
    return outcome


def _is_closed_pipe(error: Exception) -> bool:
    """Return whether a task failed because nobody reads the output any more."""
    while isinstance(error, ExceptionGroup):
        error = error.exceptions[0]
    return isinstance(error, BrokenPipeError)


def _close_stdout() -> Outcome:
    """Close standard output quietly: nobody reads it any more."""
    discard_output(sys.stdout.fileno())
    return Outcome.CLOSED_PIPE


if __name__ == '__main__':
    sys.exit(main())
