"""Plays what a page shows: writes its files, types its commands, insists on the output that it prints.

- A block with a title is a file: ```python title=lamp.py.
- A Python block without one is a program, run to its end.
- A block of the language `console` is a terminal: lines that begin with `$ ` are typed, the others must
  appear in this order. `…` stands for whatever comes; times of log lines may differ. After a last line `^C`
  the program stays while the later blocks are played: its first line must appear at once, the others until
  the page's end. Then Ctrl-C stops it: it must end with 0, or by that signal. What shows an error must end
  otherwise.
"""

from __future__ import annotations

import re
import shlex
import signal
from contextlib import ExitStack
from pathlib import Path

from helpers.command_line import executable
from helpers.forking import ForkServer
from helpers.isolation import NETWORK, isolated_env
from helpers.markdown import Block, blocks
from helpers.processes import Program

from goalwire.apps.cli.framework.outcome import Outcome

_LOG_TIME = re.compile(r'\\\[\d+\\\.\d+\\\]')
_COMMAND_ENDS = {0, Outcome.CANCELED, Outcome.INTERRUPTED}
"""How a command may end by Ctrl-C, or before it."""
_PATIENCE = 100.0
"""How many s a command may take for a line, and for its end. A page's pytest run takes 3 s alone, and ten
times as long on a busy machine. After 60 to 90 s virtual time tells which thread holds it up.
"""
_ERROR = re.compile(r'([\w.]+\.)?\w*(Error|Exception)\b|(goalwire|ros2)( \w+)*: |no: |wrong  ')


def play(page: Path, folder: Path, server: ForkServer | None = None) -> int:
    """Play a page in an empty folder; returns the number of programs it ran.

    A server forks what it can: a command or a program that sets no variables, which are for the start of an
    interpreter.
    """
    with ExitStack() as stack:
        player = _Player(folder, stack, server)
        for block in blocks(page):
            player.play(block)
        player.interrupt(player.recorders + player.staying)
        return player.count


class _Player:
    def __init__(self, folder: Path, stack: ExitStack, server: ForkServer | None) -> None:
        self._folder = folder
        self._stack = stack
        self._server = server
        self._env = isolated_env(NETWORK) | {'HUMANOID_PHYSICS': '0'}  # the body of an install without extras
        self.staying: list[tuple[Program, list[str]]] = []
        """Programs of terminals that end with ^C, and what they still have to print."""
        self.recorders: list[tuple[Program, list[str]]] = []
        """The same for those that record a bag: they end before the bag is read."""
        self.commands: list[Program] = []
        """Those of the command line."""
        self.count = 0

    def interrupt(self, ending: list[tuple[Program, list[str]]]) -> None:
        """Type the ^C of some programs, each once it has printed the rest of its output."""
        for program, output in ending:
            _expect(program, output)
            program.send_signal(signal.SIGINT)
            code = program.wait(_PATIENCE)
            ends = _COMMAND_ENDS if program in self.commands else {0, -signal.SIGINT}
            assert code in ends, f'ended with code {code}\n{program.output}'

    def play(self, block: Block) -> None:
        if block.title:
            file = self._folder / block.title
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(block.text, encoding='utf-8')
        elif block.language == 'python':
            self._start(block.text).succeed()
        elif block.language == 'console':
            for command, output in _commands(block.text):
                self._type(command, output)

    def _type(self, command: str, output: list[str]) -> None:
        if command.startswith('ros2 bag '):  # which may read a bag: its recorder has to end before
            self.interrupt(self.recorders)
            self.recorders.clear()
        program = self._run(command)
        if output[-1:] == ['^C']:
            _expect(program, output[:1])
            stays = self.recorders if command.startswith('ros2 bag record ') else self.staying
            stays.append((program, output[1:-1]))
            return
        _expect(program, output)
        code = program.wait(_PATIENCE)
        fails = any(map(_ERROR.match, output))
        assert bool(code) == fails, f'{command} ended with code {code}\n{program.output}'

    def _run(self, command: str) -> Program:
        words = shlex.split(command)
        variables = {}
        while '=' in words[0]:
            name, _, value = words.pop(0).partition('=')
            variables[name] = value
        program = words.pop(0)
        if program in {'goalwire', 'ros2', 'rqt_graph'}:
            self.commands.append(self._start(executable(program), *words, **variables))
            return self.commands[-1]
        assert program == 'python', f'{command}: a console block runs Python (write sh for what is not run)'
        if words[0] == '-c':
            return self._start(words[1], *words[2:], **variables)
        return self._start(Path(words[0]), *words[1:], **variables)  # a file, or -m

    def _start(self, source: str | Path, *arguments: str, **variables: str) -> Program:
        self.count += 1
        server = None if variables or source == Path('-m') else self._server
        environment = {**self._env, **variables}
        if arguments[:1] == ('pytest',):
            shows_hang = '-o', f'faulthandler_timeout={_PATIENCE / 2}'
            arguments = *arguments, *shows_hang
        program = Program(source, *arguments, env=environment, cwd=self._folder, server=server)
        return self._stack.enter_context(program)


def _commands(text: str) -> list[tuple[str, list[str]]]:
    """Split a terminal's text into what is typed and what then appears."""
    found: list[tuple[str, list[str]]] = []
    for line in text.splitlines():
        if line.startswith('$ '):
            found.append((line[2:], []))
        elif line.strip():
            found[-1][1].append(line)
    return found


def _expect(program: Program, output: list[str]) -> None:
    for line in output:
        if line != '…':
            program.expect(_pattern(line), _PATIENCE)


def _pattern(line: str) -> str:
    """The pattern of one line of output."""
    return '^' + _LOG_TIME.sub(lambda _: r'\[[\d.]+\]', re.escape(line)).replace('…', '.*') + '$'
