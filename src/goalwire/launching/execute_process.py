"""The action that runs a command, and how XML and YAML launch files write it."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from typing import Any

from goalwire.errors import LaunchError
from goalwire.launching.actions import Shutdown as ShutdownAction
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser
from goalwire.launching.model import Action, SomeSubstitutions, Substitution
from goalwire.launching.process import Executable, ExecuteLocal, NormalizedVariables, Variables
from goalwire.launching.values import TextSubstitution, describe_text


@expose_action('executable')
class ExecuteProcess(ExecuteLocal):
    """Runs a command as a process of the launch."""

    def __init__(
        self,
        *,
        cmd: Iterable[SomeSubstitutions],
        prefix: SomeSubstitutions | None = None,
        name: SomeSubstitutions | None = None,
        cwd: SomeSubstitutions | None = None,
        env: Variables | None = None,
        additional_env: Variables | None = None,
        **options: Any,
    ) -> None:
        description = Executable(
            cmd=cmd, prefix=prefix, name=name, cwd=cwd, env=env, additional_env=additional_env
        )
        super().__init__(process_description=description, **options)

    @classmethod
    def parse(
        cls, entity: Entity, parser: Parser, ignore: Iterable[str] = ()
    ) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        ignored = set(ignore)
        if 'cmd' not in ignored:
            arguments['cmd'] = parse_command_line(entity.get_attr('cmd'), parser)
        texts = {'cwd': 'cwd', 'name': 'name', 'launch-prefix': 'prefix', 'output': 'output'}
        texts |= {'sigterm_timeout': 'sigterm_timeout', 'sigkill_timeout': 'sigkill_timeout'}
        for attribute, argument in texts.items():
            value = None if argument in ignored else entity.get_attr(attribute, optional=True)
            if value is not None:
                arguments[argument] = parser.parse_substitution(value)
        for attribute in ('shell', 'emulate_tty', 'log_cmd', 'cached_output'):
            value = entity.get_attr(attribute, data_type=bool, optional=True, can_be_str=False)
            if value is not None:
                arguments[attribute] = value
        respawn = entity.get_attr('respawn', data_type=bool, optional=True)
        if respawn is not None:
            arguments['respawn'] = parser.parse_if_substitutions(respawn)
        delay = entity.get_attr('respawn_delay', data_type=float, optional=True, can_be_str=False)
        if delay is not None:
            arguments['respawn_delay'] = delay
        retries = entity.get_attr('respawn_max_retries', data_type=int, optional=True, can_be_str=False)
        if retries is not None:
            arguments['respawn_max_retries'] = retries
        on_exit = entity.get_attr('on_exit', optional=True)
        if on_exit is not None:
            if on_exit != 'shutdown':
                raise LaunchError(f"on_exit can only be 'shutdown', not '{on_exit}'")
            arguments['on_exit'] = [ShutdownAction()]
        variables = entity.get_entities('env')
        if variables:
            arguments['additional_env'] = {
                tuple(parser.parse_substitution(item.get_attr('name'))): parser.parse_substitution(
                    item.get_attr('value')
                )
                for item in variables
            }
            for item in variables:
                item.assert_entity_completely_parsed()
        return cls, arguments

    @classmethod
    def _parse_cmdline(cls, cmd: str, parser: Parser) -> list[list[Substitution]]:
        """Return the result of parse_command_line(). Derived classes in other packages call this method."""
        return parse_command_line(cmd, parser)

    @property
    def name(self) -> str | list[Substitution] | None:
        return self.process_description.final_name or self.process_description.name

    @property
    def cmd(self) -> list[list[Substitution]]:
        return self.process_description.cmd

    @property
    def cwd(self) -> list[Substitution] | None:
        return self.process_description.cwd

    @property
    def env(self) -> NormalizedVariables | None:
        return self.process_description.env

    @property
    def additional_env(self) -> NormalizedVariables | None:
        return self.process_description.additional_env

    @property
    def prefix(self) -> list[Substitution]:
        return self.process_description.prefix

    def describe(self) -> str:
        return f'{type(self).__name__}({" ".join(describe_text(part) for part in self.cmd)})'


def parse_command_line(cmd: str, parser: Parser) -> list[list[Substitution]]:
    """Split a command line as a shell does, but never inside a substitution."""
    words: list[list[Substitution]] = []
    word: list[Substitution] | None = None
    for part in parser.parse_substitution(cmd):
        if not isinstance(part, TextSubstitution):
            word = [*(word or []), part]
            continue
        text = part.text
        tokens = shlex.split(text)
        if text[:1].isspace() and word:
            words.append(word)
            word = None
        for position, token in enumerate(tokens):
            if position:
                words.append(word or [])
                word = None
            word = [*(word or []), TextSubstitution(text=token)]
        if text[-1:].isspace() and word:
            words.append(word)
            word = None
    if word:
        words.append(word)
    return words
