"""ros2 param: set, load, delete. Before a value is sent, it is converted to the parameter's declared type."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING, Any

from goalwire.apps.cli.commands.param.reading import parameter_arguments, parameters_of
from goalwire.apps.cli.framework import lookup
from goalwire.apps.cli.framework.live import live
from goalwire.apps.cli.framework.nodes import find_node
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.errors import FieldValueError, FileShapeError

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.cli.framework.output import Output
    from goalwire.rules.parameters.parameter import Type

_SET = 'Set parameter successful', 'Setting parameter failed'
_DELETED = 'Deleted parameter successfully', 'Deleting parameter failed'


# -- set -----------------------------------------------------------------------------------------------------


def set_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `param set`."""
    parameter_arguments(parser)
    parser.add_argument(
        'pairs', nargs='+', metavar='NAME VALUE', help='Names and values, in YAML; name=value, too'
    )


def _pairs(words: list[str]) -> list[tuple[str, str]]:
    if all('=' in word for word in words):
        return [(name, value) for name, _, value in (word.partition('=') for word in words)]
    if len(words) % 2:
        raise CommandError(
            Outcome.USAGE,
            f"the parameter '{words[-1]}' is given no value",
            'write: NAME VALUE [NAME VALUE …]',
        )
    return list(zip(words[::2], words[1::2], strict=True))


def change(arguments: Namespace, output: Output) -> Outcome:
    """Set parameters; if one value does not fit, none is sent."""
    pairs = _pairs(arguments.pairs)
    name = find_node(arguments)

    async def perform(node: goalwire.Node) -> Outcome:
        parameters = parameters_of(node, name, arguments)
        declared = await parameters.descriptors([each for each, _ in pairs])
        try:
            wanted = [(each, _value_of_text(each, text, declared.get(each))) for each, text in pairs]
        except FieldValueError as error:
            raise CommandError(
                Outcome.BAD_VALUE,
                f"the parameter '{error.path}' of '{name}': {error.problem}",
                f'see: ros2 param list {name} --param-type',
            ) from None
        report = _Report(name, output)
        for each, result in await parameters.set(wanted):
            done, failed = (f'{each}: {text}' for text in _SET) if len(pairs) > 1 else _SET
            report.show(each, result, done, failed)
        return report.outcome

    return live(perform)


def _value_of_text(name: str, text: str, descriptor: Any) -> Any:
    """Return the ParameterValue message for a text; raises FieldValueError."""
    from goalwire.entities.parameters.files import parameter_value_from_text
    from goalwire.rules.parameters.fitting import fit_parameter_text
    from goalwire.rules.parameters.parameter import value_message

    type_ = _find_fixed_type(descriptor)
    if type_ is None:
        return parameter_value_from_text(text)
    return value_message(type_, fit_parameter_text(name, type_, text))


# -- delete --------------------------------------------------------------------------------------------------


def delete_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `param delete`."""
    parameter_arguments(parser)
    parser.add_argument('parameter_name', help='Name of the parameter')


def delete(arguments: Namespace, output: Output) -> Outcome:
    """Delete a parameter."""
    from rcl_interfaces.msg import ParameterValue

    name = find_node(arguments)

    async def perform(node: goalwire.Node) -> Outcome:
        report = _Report(name, output)
        wanted = [(arguments.parameter_name, ParameterValue())]
        for each, result in await parameters_of(node, name, arguments).set(wanted):
            report.show(each, result, *_DELETED)
        return report.outcome

    return live(perform)


# -- load ----------------------------------------------------------------------------------------------------


def load_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `param load`."""
    parameter_arguments(parser)
    parser.add_argument('parameter_file', help='A file as param dump writes it')
    parser.add_argument(
        '--no-use-wildcard', action='store_true', help="Leave out what the file has for '/**'"
    )


def load(arguments: Namespace, output: Output) -> Outcome:
    """Set the values of a file; as in ROS 2, a refused parameter does not affect the others.

    A read-only parameter that already has the file's value is reported and skipped: every dump has some.
    """
    name, file = find_node(arguments), arguments.parameter_file
    given = _read(file, name, use_wildcard=not arguments.no_use_wildcard)

    async def perform(node: goalwire.Node) -> Outcome:
        report = _Report(name, output)
        parameters = parameters_of(node, name, arguments)
        declared = await parameters.descriptors(list(given))
        held = await parameters.values([each for each, about in declared.items() if about.read_only])
        wanted = []
        for each, data in given.items():
            try:
                value = _value_of_data(each, data, declared.get(each))
            except (FieldValueError, FileShapeError) as error:
                report.refuse(each, getattr(error, 'problem', str(error)))
                continue
            if each in held and held[each] == value:
                report.pass_over(each)
            else:
                wanted.append((each, value))
        for each, result in await parameters.set(wanted):
            report.show(each, result, f'Set parameter {each} successful', f'Set parameter {each} failed')
        return report.outcome

    return live(perform)


def _read(file: str, node_name: str, *, use_wildcard: bool) -> dict[str, object]:
    """Return a file's values for a node, by name. Raises CommandError if there are none."""
    from goalwire.entities.parameters.files import values_from_yaml_file

    try:
        given = values_from_yaml_file(file, node_name, use_wildcard=use_wildcard)
    except OSError as error:
        problem = f"cannot load '{file}': {error.strerror or error}"
        raise CommandError(Outcome.NOT_FOUND, problem, 'name another file') from None
    except (FieldValueError, FileShapeError) as error:
        problem = f"cannot load '{file}': {lookup.one_line(str(error))}"
        raise CommandError(Outcome.BAD_VALUE, problem, 'name another file') from None
    if not given:
        raise CommandError(
            Outcome.NOT_FOUND,
            f"'{file}' has no parameters for '{node_name}'",
            f'see: ros2 param dump {node_name}',
        )
    return given


def _value_of_data(name: str, data: object, descriptor: Any) -> Any:
    """Return the ParameterValue message for YAML's data; raises FieldValueError, FileShapeError."""
    from goalwire.idl.field_values import plain_values
    from goalwire.rules.parameters.fitting import fit_parameter
    from goalwire.rules.parameters.parameter import value_message
    from goalwire.rules.parameters.plain_yaml import read_typed_value

    type_ = _find_fixed_type(descriptor)
    if type_ is None:
        return value_message(*read_typed_value(name, plain_values(data)))
    return value_message(type_, fit_parameter(name, type_, data))


# -- shared by set, delete and load --------------------------------------------------------------------------


def _find_fixed_type(descriptor: Any) -> Type | None:
    """Return the declared type of a parameter; None if it is dynamically typed or not declared."""
    from goalwire.rules.parameters.fitting import KIND_NAMES
    from goalwire.rules.parameters.parameter import Type

    if descriptor is None or descriptor.dynamic_typing or descriptor.type >= len(Type):
        return None
    type_ = Type(descriptor.type)
    return type_ if type_ in KIND_NAMES else None


class _Report:
    """Prints the outcome for each parameter, and holds the command's exit code."""

    def __init__(self, node_name: str, output: Output) -> None:
        self._node_name = node_name
        self._output = output
        self.outcome = Outcome.OK

    def show(self, name: str, result: Any, done: str, failed: str) -> None:
        """Print the node's answers."""
        text = (done if result.successful else failed) + (f': {result.reason}' if result.reason else '')
        self._data(name, successful=result.successful, reason=result.reason)
        if not result.successful:
            tell(lookup.one_line(text))
            self.outcome = self.outcome or Outcome.REFUSED
        elif not self._output.json:
            self._output.line(text)

    def refuse(self, name: str, problem: str) -> None:
        """Print that a value does not fit, and has not been sent."""
        self._data(name, successful=False, reason=problem)
        tell(lookup.one_line(f'Set parameter {name} failed: {problem}'))
        self.outcome = Outcome.BAD_VALUE

    def pass_over(self, name: str) -> None:
        """Print that a read-only parameter is left as it is."""
        reason = 'it is read-only, and has this value already'
        self._data(name, successful=True, reason=reason)
        tell(f'Parameter {name} is passed over: {reason}')

    def _data(self, name: str, *, successful: bool, reason: str) -> None:
        if self._output.json:
            self._output.data(
                {'node': self._node_name, 'name': name, 'successful': successful, 'reason': reason}
            )
