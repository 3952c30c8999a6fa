"""Parses ROS arguments: those between `--ros-args` and `--` on a command line (rcl/arguments.h)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from goalwire.errors import LocalError
from goalwire.files import show
from goalwire.logging.record import LoggingSeverity
from goalwire.records import record
from goalwire.rules.names.lexer import Lexeme, Lexer, RuleSyntaxError, node_prefix, refuse_wildcard
from goalwire.rules.names.remapping import RemapRule, parse_remap_rule
from goalwire.rules.names.validation import InvalidName, validate_enclave

if TYPE_CHECKING:
    from goalwire.rules.parameters import ParameterValue
    from goalwire.rules.parameters.file_syntax import NodeValues


_LONGEST_SHOWN = 500  # the most characters of an argument that an error shows


class ArgumentError(LocalError, ValueError):
    """An error for ROS arguments that cannot be parsed. The text is ROS 2's own.

    Programs get RCLError or RCLInvalidROSArgsError.
    """


class UnknownArguments(ArgumentError):
    """An error for ROS arguments that ROS 2 does not know: `arguments`. Programs get UnknownROSArgsError."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self.arguments = tuple(arguments)
        super().__init__(str([show(argument, _LONGEST_SHOWN) for argument in arguments]))


@record
class ParameterOverride:
    """An argument `-p [node:]name:=value`.

    As in rcl, `node` means the node of that name in the root namespace.
    """

    name: str
    value: ParameterValue
    node: str | None = None

    @property
    def nodes(self) -> NodeValues:
        """The value in two dicts: by the name of the nodes that take it, then by the parameter's name."""
        return {self.node or '/**': {self.name: self.value}}


_UNREAD: NodeValues = {}


@record
class ParameterFile:
    """An argument `--params-file PATH`, and the file's content once it has been read."""

    path: str
    nodes: NodeValues = _UNREAD

    COMPARE_EXCLUDE = ('nodes',)


@record
class Arguments:
    """The ROS arguments of a command line; `rest` has the other arguments in their order."""

    remaps: tuple[RemapRule, ...] = ()
    parameters: tuple[ParameterOverride | ParameterFile, ...] = ()
    """The overrides in the order given. A later override of the same parameter wins."""
    log_levels: tuple[tuple[str, LoggingSeverity], ...] = ()
    """Pairs of logger name and severity; the name '' is the default of all loggers."""
    enclave: str | None = None
    stdout_logs: bool = True
    rosout_logs: bool = True
    external_lib_logs: bool = True
    log_config_file: str | None = None
    log_file_name: str | None = None
    rest: tuple[str, ...] = ()
    deprecated: tuple[str, ...] = ()
    """Remap rules found outside `--ros-args`. They are applied, and ROS 2 warns of them."""

    def overrides_for(self, full_node_name: str) -> dict[str, ParameterValue]:
        """Return the parameters that `-p` and the files give to the node with this fully qualified name.

        As in rcl, the values are first grouped by the node names or patterns for which they are given; `-p`
        without a node means `/**`. Then the groups that match the node are applied in the order of their
        first appearance, and a value of a later group wins.
        """
        nodes: NodeValues = {}
        for item in self.parameters:
            for pattern, values in item.nodes.items():
                nodes.setdefault(pattern, {}).update(values)
        if not nodes:
            return {}
        from goalwire.rules.parameters.file_syntax import matches

        found: dict[str, ParameterValue] = {}
        for pattern, values in nodes.items():
            if matches(pattern, full_node_name):
                found.update(values)
        return found

    @property
    def params_files(self) -> tuple[str, ...]:
        """Return the paths of all `--params-file` arguments, in the order given."""
        return tuple(item.path for item in self.parameters if isinstance(item, ParameterFile))


def parse_arguments(arguments: Sequence[str]) -> Arguments:
    """Read a command line, its program name included or not.

    Raises ArgumentError with ROS 2's text for a rule that does not parse, UnknownArguments for unknown ROS
    arguments, TypeError for an argument that is not a string. Parameter files are not read.
    """
    parser = _Parser()
    parser.read(arguments)
    if parser.unknown:
        raise UnknownArguments(parser.unknown)
    return parser.result()


def parse_parameter_rule(text: str) -> ParameterOverride:
    """Read `[node:]name:=value`; raises RuleSyntaxError with ROS 2's text."""
    from goalwire.rules.parameters.value_syntax import parse_parameter_value

    lexer = Lexer(text)
    node = node_prefix(lexer)
    name = _parameter_name_part(lexer)
    while lexer.peek() is not Lexeme.SEPARATOR:
        name += lexer.expect(Lexeme.DOT) + _parameter_name_part(lexer)
    lexer.expect(Lexeme.SEPARATOR)
    if not lexer.rest():
        raise RuleSyntaxError('error not set')
    return ParameterOverride(name, parse_parameter_value(lexer.rest()), node)


def parse_log_level(text: str) -> tuple[str, LoggingSeverity]:
    """Read `LEVEL` or `name:=LEVEL`; raises RuleSyntaxError with ROS 2's text."""
    name, separator, level = text.partition(':=')
    if not separator:
        return '', _severity(text)
    if not name:
        raise RuleSyntaxError('Argument has an invalid logger item that name is empty')
    lexer = Lexer(text)
    lexer.index = len(name) + len(separator)
    lexer.expect(Lexeme.TOKEN)
    lexer.expect(Lexeme.EOF)
    return name, _severity(level)


def _severity(text: str) -> LoggingSeverity:
    try:
        return LoggingSeverity[text.upper()]
    except KeyError:
        raise RuleSyntaxError('Argument does not use a valid severity level') from None


def _parameter_name_part(lexer: Lexer) -> str:
    """Read a part of a parameter's name: tokens and slashes, as rcl accepts `a/b`, `/a` and even `a//b`."""
    refuse_wildcard(lexer)
    part = ''
    while piece := lexer.accept({Lexeme.TOKEN, Lexeme.FORWARD_SLASH}):
        part += piece
    if not part:
        raise RuleSyntaxError('Expecting token or wildcard')
    return part


_SWITCHES = {
    f'--{verb}-{what.replace("_", "-")}': (what, verb == 'enable')
    for verb in ('enable', 'disable')
    for what in ('stdout_logs', 'rosout_logs', 'external_lib_logs')
}


class _Parser:
    """Parses the texts of a command line one by one, and collects the arguments."""

    def __init__(self) -> None:
        self.remaps: list[RemapRule] = []
        self.parameters: list[ParameterOverride | ParameterFile] = []
        self.log_levels: list[tuple[str, LoggingSeverity]] = []
        self.enclave: str | None = None
        self.switches: dict[str, bool] = {}
        self.log_config_file: str | None = None
        self.log_file_name: str | None = None
        self.rest: list[str] = []
        self.deprecated: list[str] = []
        self.unknown: list[str] = []

    def read(self, arguments: Sequence[str]) -> None:
        in_ros_args = False
        remaining = iter(arguments)
        for argument in remaining:
            if not isinstance(argument, str):
                raise TypeError(f'command line arguments are strings, got {argument!r}')
            if argument == '--ros-args':
                in_ros_args = True
            elif not in_ros_args:
                self._outside(argument)
            elif argument == '--':
                in_ros_args = False
            elif argument in _SWITCHES:
                what, on = _SWITCHES[argument]
                self.switches[what] = on
            elif argument in _VALUED:
                _VALUED[argument](self, argument, next(remaining, None))
            else:
                self.unknown.append(argument)

    def result(self) -> Arguments:
        return Arguments(
            remaps=tuple(self.remaps),
            parameters=tuple(self.parameters),
            log_levels=tuple(self.log_levels),
            enclave=self.enclave,
            log_config_file=self.log_config_file,
            log_file_name=self.log_file_name,
            rest=tuple(self.rest),
            deprecated=tuple(self.deprecated),
            **self.switches,
        )

    def _outside(self, argument: str) -> None:
        try:
            self.remaps.append(parse_remap_rule(argument))
        except RuleSyntaxError:
            self.rest.append(argument)
        else:
            self.deprecated.append(argument)

    def remap(self, flag: str, text: str | None) -> None:
        text = _require(text, f'{flag} flag. No remap rule found.')
        with _saying(f"remap rule: '{flag} {text}'", _assignment_hint(flag, text)):
            self.remaps.append(parse_remap_rule(text))

    def parameter(self, flag: str, text: str | None) -> None:
        text = _require(text, f'{flag} flag. No parameter override rule found.')
        with _saying(f"parameter override rule: '{flag} {text}'", _assignment_hint(flag, text)):
            self.parameters.append(parse_parameter_rule(text))

    def log_level(self, flag: str, text: str | None) -> None:
        text = _require(text, f"log level flag: '{flag}'. No log level provided.")
        with _saying(f"log level: '{flag} {text}'"):
            self.log_levels.append(parse_log_level(text))

    def params_file(self, flag: str, text: str | None) -> None:
        self.parameters.append(ParameterFile(_require(text, f'{flag} flag. No file path provided.')))

    def enclave_path(self, flag: str, text: str | None) -> None:
        text = _require(text, f'{flag} flag. No enclave path provided.')
        try:
            validate_enclave(text)
        except InvalidName as error:
            raise ArgumentError(
                f"Enclave name is not valid: '{error.reason}'. Invalid index: {error.index}"
            ) from error
        self.enclave = text

    def config_file(self, flag: str, text: str | None) -> None:
        self.log_config_file = _require(text, f'{flag} flag. No file path provided.')

    def file_name(self, flag: str, text: str | None) -> None:
        self.log_file_name = _require(text, f'{flag} flag. No string prefix provided.')


_VALUED: dict[str, Callable[[_Parser, str, str | None], None]] = {
    '-r': _Parser.remap,
    '--remap': _Parser.remap,
    '-p': _Parser.parameter,
    '--param': _Parser.parameter,
    '--params-file': _Parser.params_file,
    '--log-level': _Parser.log_level,
    '--log-config-file': _Parser.config_file,
    '--log-file-name': _Parser.file_name,
    '-e': _Parser.enclave_path,
    '--enclave': _Parser.enclave_path,
}


def _require(text: str | None, complaint: str) -> str:
    if text is None:
        raise ArgumentError(f"Couldn't parse trailing {complaint}")
    return text


def _assignment_hint(flag: str, text: str) -> str:
    """Return a hint on how to write a rule whose `:=` or value is missing; '' if neither is missing."""
    if text.endswith(':='):
        return f"; what stands behind := is missing (write '{flag} {show(text, _LONGEST_SHOWN)}…')"
    if ':=' in text:
        return ''
    name, sign, value = text.partition('=') if '=' in text else text.partition(':')
    wanted = f'{name.strip()}:={value.strip()}' if sign else f'{name}:=…'
    return f"; write '{flag} {show(wanted, _LONGEST_SHOWN)}', with :="


@contextmanager
def _saying(what: str, hint: str = '') -> Iterator[None]:
    """Turn a RuleSyntaxError in the block into an ArgumentError that names the option and its value."""
    try:
        yield
    except RuleSyntaxError as error:
        text = f"Couldn't parse {show(what, _LONGEST_SHOWN)}. Error: {show(str(error), _LONGEST_SHOWN)}"
        raise ArgumentError(f'{text}{hint}') from error
