"""The substitutions of the package launch, apart from those that are conditions."""

from __future__ import annotations

import os
import secrets
import shlex
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterable, Sequence
from typing import Any, ClassVar

from goalwire.errors import SubstitutionFailure
from goalwire.files import show
from goalwire.launching import expressions
from goalwire.launching.exposure import expose_substitution
from goalwire.launching.model import LaunchContext, SomeSubstitutions, Substitution
from goalwire.launching.values import (
    TextSubstitution,
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = [
    'AnonName',
    'Command',
    'EnvironmentVariable',
    'FileContent',
    'FindExecutable',
    'LaunchConfiguration',
    'LaunchLogDir',
    'LocalSubstitution',
    'PathJoinSubstitution',
    'PathSubstitution',
    'PythonExpression',
    'StringJoinSubstitution',
    'SubstitutionFailure',
    'TextSubstitution',
    'ThisLaunchFile',
    'ThisLaunchFileDir',
]


class CompoundSubstitution(Substitution):
    """A substitution with texts as arguments: `names` are their names; the first `least` are required."""

    names: ClassVar[tuple[str, ...]] = ()
    least: ClassVar[int | None] = None

    def __init__(self, *parts: SomeSubstitutions) -> None:
        self._parts = [normalize_to_list_of_substitutions(part) for part in parts]

    def describe(self) -> str:
        return f'{type(self).__name__}({", ".join(describe_text(part) for part in self._parts)})'

    @classmethod
    def parse(cls, data: Sequence[SomeSubstitutions]) -> tuple[type[Substitution], dict[str, Any]]:
        least = len(cls.names) if cls.least is None else cls.least
        if not least <= len(data) <= len(cls.names):
            wanted = f'{least}' if least == len(cls.names) else f'{least} to {len(cls.names)}'
            raise TypeError(f'{cls.__name__} expects {wanted} arguments, got {len(data)}')
        return cls, dict(zip(cls.names, data, strict=False))

    def _text(self, context: LaunchContext, part: int) -> str:
        return perform_substitutions(context, self._parts[part])


@expose_substitution('var')
class LaunchConfiguration(CompoundSubstitution):
    """The value of a launch argument or configuration."""

    names = ('variable_name', 'default')
    least = 1

    def __init__(self, variable_name: SomeSubstitutions, *, default: Any = None) -> None:
        super().__init__(variable_name)
        self._default: list[Substitution] | None = None
        if default is not None:
            self._default = normalize_to_list_of_substitutions(
                str(default) if isinstance(default, int | float | bool) else default
            )

    @property
    def variable_name(self) -> list[Substitution]:
        return self._parts[0]

    @property
    def default(self) -> list[Substitution] | None:
        return self._default

    def describe(self) -> str:
        return f'LaunchConfig({describe_text(self._parts[0])})'

    def perform(self, context: LaunchContext) -> str:
        name = self._text(context, 0)
        if name in context.launch_configurations:
            return str(context.launch_configurations[name])
        if self._default is None:
            raise SubstitutionFailure(
                f"launch configuration '{name}' does not exist: declare it with DeclareLaunchArgument or "
                f'<arg name="{name}"/> above this line, or pass {name}:=VALUE'
            )
        return perform_substitutions(context, self._default)


@expose_substitution('env', 'optenv')
class EnvironmentVariable(CompoundSubstitution):
    """The value of an environment variable."""

    names = ('name', 'default_value')
    least = 1

    def __init__(self, name: SomeSubstitutions, *, default_value: SomeSubstitutions | None = None) -> None:
        super().__init__(name)
        self._default = None if default_value is None else normalize_to_list_of_substitutions(default_value)

    @property
    def name(self) -> list[Substitution]:
        return self._parts[0]

    @property
    def default_value(self) -> list[Substitution] | None:
        return self._default

    def describe(self) -> str:
        return f'EnvVar({describe_text(self._parts[0])})'

    def perform(self, context: LaunchContext) -> str:
        name = self._text(context, 0)
        found = context.environment.get(name)
        if found is not None:
            return found
        if self._default is None:
            raise SubstitutionFailure(
                f"environment variable '{name}' does not exist, and has no default here"
            )
        return perform_substitutions(context, self._default)


@expose_substitution('eval')
class PythonExpression(CompoundSubstitution):
    """The value of a Python expression, as a text. expressions.py defines which expressions are allowed."""

    names = ('expression', 'python_modules')
    least = 1

    def __init__(self, expression: SomeSubstitutions, python_modules: SomeSubstitutions = ('math',)) -> None:
        super().__init__(expression)
        self._modules = normalize_to_list_of_substitutions(python_modules)

    @property
    def expression(self) -> list[Substitution]:
        return self._parts[0]

    def describe(self) -> str:
        modules = ', '.join(item.describe() for item in self._modules)
        return f'PythonExpr({describe_text(self._parts[0])}, [{modules}])'

    def perform(self, context: LaunchContext) -> str:
        modules = [name.strip() for item in self._modules for name in item.perform(context).split(',')]
        return expressions.evaluate(self._text(context, 0), [name for name in modules if name])


def _resolve_program(words: list[str]) -> list[str]:
    """Return the command; a program that is not on PATH is taken from this Python's folder of scripts."""
    if words and os.path.dirname(words[0]) == '' and shutil.which(words[0]) is None:
        beside = shutil.which(words[0], path=os.path.dirname(sys.executable))
        return [beside or words[0], *words[1:]]
    return words


@expose_substitution('command')
class Command(CompoundSubstitution):
    """The output of a program, which runs without a shell when the text is needed.

    `on_stderr` says what to do if the program prints to its standard error: 'fail', 'ignore', 'warn', or
    'capture', which adds this output to the result.
    """

    names = ('command', 'on_stderr')
    least = 1

    def __init__(self, command: SomeSubstitutions, *, on_stderr: SomeSubstitutions = 'fail') -> None:
        super().__init__(command)
        self._on_stderr = normalize_to_list_of_substitutions(on_stderr)

    @property
    def command(self) -> list[Substitution]:
        return self._parts[0]

    def describe(self) -> str:
        return f'Command({describe_text(self._parts[0])})'

    def perform(self, context: LaunchContext) -> str:
        text = self._text(context, 0)
        on_stderr = perform_substitutions(context, self._on_stderr)
        if on_stderr not in {'fail', 'ignore', 'warn', 'capture'}:
            raise SubstitutionFailure(f"on_stderr is fail, ignore, warn or capture, not '{on_stderr}'")
        try:
            done = subprocess.run(  # noqa: S603 - the file says which program
                _resolve_program(shlex.split(text)),
                check=False,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT if on_stderr == 'capture' else subprocess.PIPE,
                text=True,
                errors='replace',
            )
        except (OSError, ValueError) as error:
            advice = '; run: pip install xacro' if text.split()[:1] == ['xacro'] else ''
            raise SubstitutionFailure(f"cannot run the command '{text}': {error}{advice}") from error
        said = (done.stderr or '').strip()
        if done.returncode:
            raise SubstitutionFailure(
                f"the command '{text}' failed with exit code {done.returncode}"
                + (f': {said}' if said else '')
            )
        if said and on_stderr == 'fail':
            raise SubstitutionFailure(f"the command '{text}' printed to its standard error: {said}")
        if said and on_stderr == 'warn':
            from goalwire.launching.output import get_logger

            get_logger('launch').warning(f"the command '{text}' printed to its standard error: {said}")
        return done.stdout


@expose_substitution('find-exec')
class FindExecutable(CompoundSubstitution):
    """The path of a program on PATH."""

    names = ('name',)

    def __init__(self, *, name: SomeSubstitutions) -> None:
        super().__init__(name)

    @property
    def name(self) -> list[Substitution]:
        return self._parts[0]

    def describe(self) -> str:
        return f'FindExec({describe_text(self._parts[0])})'

    def perform(self, context: LaunchContext) -> str:
        name = self._text(context, 0)
        found = shutil.which(name, path=context.environment.get('PATH'))
        if found is None:
            raise SubstitutionFailure(f"executable '{name}' not found on the PATH")
        return found


@expose_substitution('dirname')
class ThisLaunchFileDir(Substitution):
    """The folder of the launch file."""

    def describe(self) -> str:
        return 'ThisLaunchFileDir()'

    def perform(self, context: LaunchContext) -> str:
        return _of_this_file(context, 'current_launch_file_directory')


@expose_substitution('filename')
class ThisLaunchFile(Substitution):
    """The path of the launch file."""

    def describe(self) -> str:
        return 'ThisLaunchFile()'

    def perform(self, context: LaunchContext) -> str:
        return _of_this_file(context, 'current_launch_file_path')


def _of_this_file(context: LaunchContext, name: str) -> str:
    found: str | None = context.get_locals_as_dict().get(name)
    if found is None:
        raise SubstitutionFailure('there is no current launch file: this description comes from a script')
    return found


@expose_substitution('launch_log_dir', 'log_dir')
class LaunchLogDir(Substitution):
    """The folder of this launch's log files."""

    def describe(self) -> str:
        return 'LaunchLogDir()'

    def perform(self, context: LaunchContext) -> str:
        from goalwire.launching.output import launch_config

        return launch_config.log_dir


class LocalSubstitution(Substitution):
    """The value of a local name, such as `event.pid` in an event handler."""

    def __init__(self, expression: str, description: str | None = None) -> None:
        self._expression = expression
        self._description = description

    @property
    def expression(self) -> str:
        return self._expression

    def describe(self) -> str:
        return f"LocalVar('{self._description or self._expression}')"

    def perform(self, context: LaunchContext) -> str:
        first, *rest = self._expression.split('.')
        try:
            found = context.get_locals_as_dict()[first]
            for name in rest:
                found = getattr(found, name)
        except (KeyError, AttributeError) as error:
            raise SubstitutionFailure(f"there is no local variable '{self._expression}' here") from error
        return str(found)


@expose_substitution('anon')
class AnonName(CompoundSubstitution):
    """A name with a unique suffix. Within one launch a name always gets the same suffix."""

    names = ('name',)

    def __init__(self, name: SomeSubstitutions) -> None:
        super().__init__(name)

    @property
    def name(self) -> list[Substitution]:
        return self._parts[0]

    def perform(self, context: LaunchContext) -> str:
        name = self._text(context, 0)
        key = f'anon{name}'
        if key not in context.launch_configurations:
            unique = f'{name}_{socket.gethostname()}_{os.getpid()}_{secrets.randbits(48)}'
            context.launch_configurations[key] = unique.replace('.', '_').replace('-', '_').replace(':', '_')
        return str(context.launch_configurations[key])


@expose_substitution('file-content')
class FileContent(CompoundSubstitution):
    """The contents of a text file."""

    names = ('path',)

    def __init__(self, path: SomeSubstitutions) -> None:
        super().__init__(path)

    def perform(self, context: LaunchContext) -> str:
        path = self._text(context, 0)
        try:
            with open(path, encoding='utf-8') as file:
                return file.read()
        except (OSError, UnicodeError) as error:
            raise SubstitutionFailure(f'cannot read {show(path)}: {error}') from error


class PathSubstitution(CompoundSubstitution):
    """A path; the operator `/` appends to it."""

    def __init__(self, path: SomeSubstitutions) -> None:
        super().__init__(path)

    def __truediv__(self, more: SomeSubstitutions) -> PathJoinSubstitution:
        return PathJoinSubstitution([self, more])

    def perform(self, context: LaunchContext) -> str:
        return self._text(context, 0)


class PathJoinSubstitution(CompoundSubstitution):
    """Parts of a path, joined by the system's separator. If a part is a list, its texts are concatenated."""

    def __init__(self, substitutions: Iterable[SomeSubstitutions]) -> None:
        super().__init__(*substitutions)

    @property
    def substitutions(self) -> list[list[Substitution]]:
        return self._parts

    def describe(self) -> str:
        return f'PathJoin({", ".join(describe_text(part) for part in self._parts)})'

    def __truediv__(self, more: SomeSubstitutions) -> PathJoinSubstitution:
        return PathJoinSubstitution([*self._parts, more])

    def perform(self, context: LaunchContext) -> str:
        texts = [perform_substitutions(context, part) for part in self._parts]
        return os.path.join(*texts) if texts else ''


@expose_substitution('string-join')
class StringJoinSubstitution(CompoundSubstitution):
    """Texts with a delimiter between them."""

    def __init__(self, substitutions: Iterable[SomeSubstitutions], delimiter: SomeSubstitutions = '') -> None:
        super().__init__(*substitutions)
        self._delimiter = normalize_to_list_of_substitutions(delimiter)

    @classmethod
    def parse(cls, data: Sequence[SomeSubstitutions]) -> tuple[type[Substitution], dict[str, Any]]:
        if len(data) < 2:
            raise TypeError('string-join expects a delimiter and at least one text')
        return cls, {'delimiter': data[0], 'substitutions': data[1:]}

    def perform(self, context: LaunchContext) -> str:
        texts = [perform_substitutions(context, part) for part in self._parts]
        return perform_substitutions(context, self._delimiter).join(texts)
