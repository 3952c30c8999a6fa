"""The parameters of a node: declares, overrides, reads and sets them, with rclpy's exceptions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeVar, overload

from goalwire.entities.parameters.declaration import Described, declarations, described
from goalwire.entities.parameters.set_callbacks import SetParametersCallbacks
from goalwire.errors import (
    InvalidHandle,
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterAlreadyDeclaredException,
    ParameterImmutableException,
    ParameterNotDeclaredException,
    ParameterUninitializedException,
    did_you_mean,
)
from goalwire.logging import get_logger
from goalwire.places import at, dropping_place
from goalwire.rules.parameters import (
    RELATIVE_TOLERANCE,
    SEPARATOR,
    Descriptor,
    Outcome,
    Parameter,
    ParameterTable,
    ParameterValue,
    Type,
    WrongType,
)
from goalwire.rules.parameters.callbacks import NO_ANSWER, NOTHING_LEFT
from goalwire.rules.parameters.listing import list_names
from goalwire.rules.parameters.messages import descriptor_message, result_message, value_of

if TYPE_CHECKING:
    from rcl_interfaces.msg import (
        ListParametersResult,
        ParameterDescriptor,
        SetParametersResult,
    )
    from rcl_interfaces.msg import ParameterValue as ParameterValueMessage

    from goalwire.entities.node import NodeCore
    from goalwire.entities.parameters.events import ParameterEvents

DefaultT = TypeVar('DefaultT')


class NodeParameters(SetParametersCallbacks):
    """Mixed into Node. A ParameterTable holds the values; callers see rclpy's types."""

    PARAM_REL_TOL = RELATIVE_TOLERANCE

    if TYPE_CHECKING:

        @property
        def handle(self) -> NodeCore:
            """The node that does the work: goalwire's own, which both APIs share."""

    _ros_parameter_events: ParameterEvents | None = None

    def _ros_init_parameters(self, overrides: Iterable[Parameter], *, allow_undeclared: bool) -> None:
        values: dict[str, ParameterValue] = dict(self.handle.parameter_overrides())
        values.update({parameter.name: parameter.value for parameter in overrides})
        self._ros_parameters = ParameterTable(values, allow_undeclared=allow_undeclared)
        self._ros_init_set_callbacks()
        if (use := self.handle.override_use) is not None:
            use.note_node(self.handle.name.qualified)

    def _ros_declare_overrides(self) -> None:
        values = self._ros_parameters.overrides.items()
        self.declare_parameters('', [(name, value, Descriptor()) for name, value in values])

    # -- declaring -----------------------------------------------------------------------------------------

    @overload
    def declare_parameter(
        self,
        name: str,
        value: Type | ParameterValueMessage | None = None,
        descriptor: Described | None = None,
        ignore_override: bool = False,
    ) -> Parameter: ...
    @overload
    def declare_parameter(
        self,
        name: str,
        value: DefaultT,
        descriptor: Described | None = None,
        ignore_override: bool = False,
    ) -> Parameter[DefaultT]: ...
    def declare_parameter(
        self,
        name: str,
        value: object = None,
        descriptor: Described | None = None,
        ignore_override: bool = False,
    ) -> Parameter:
        """Declare a parameter with a default value (or, without one, a Type) and return it.

        The value may be an rcl_interfaces/msg/ParameterValue.

        An override, from arguments or files, wins over the default. Raises ParameterAlreadyDeclaredException,
        InvalidParameterException, InvalidParameterTypeException, InvalidParameterValueException, TypeError,
        ValueError.
        """
        alone = value is None and descriptor is None
        given = (name,) if alone else (name, value, descriptor)
        return self._ros_declare('', [given], ignore_override)[0]

    def declare_parameters(
        self, namespace: str, parameters: Sequence[tuple[Any, ...]], ignore_override: bool = False
    ) -> list[Parameter]:
        """Declare several parameters, each `(name[, value[, descriptor]])`, under a namespace (may be '').

        Raises as declare_parameter does; parameters before the refused one stay declared.
        """
        return self._ros_declare(namespace, parameters, ignore_override)

    def _ros_declare(self, namespace: str, given: Sequence[Sequence[Any]], ignore: bool) -> list[Parameter]:
        declared = declarations(namespace, given, {} if ignore else self._ros_parameters.overrides)
        known = [parameter.name for parameter, _ in declared if parameter.name in self._ros_parameters]
        if known:
            raise ParameterAlreadyDeclaredException(known)
        for parameter, descriptor in declared:
            outcome = descriptor.judge(parameter)
            if outcome.successful:
                outcome = self._ros_change([parameter], {parameter.name: descriptor})
            if isinstance(outcome, WrongType):
                raise _wrong_type(parameter, descriptor.type)
            if not outcome.successful:
                raise InvalidParameterValueException(parameter.name, parameter.value, outcome.reason)
        if (use := self.handle.override_use) is not None:
            for parameter, _ in declared:
                use.declared(self.handle.name.qualified, parameter.name)
        return [parameter for parameter, _ in declared]

    def undeclare_parameter(self, name: str) -> None:
        """Forget a parameter; raises ParameterNotDeclaredException, ParameterImmutableException."""
        if name not in self._ros_parameters:
            raise self._ros_not_declared(name)
        self._ros_refuse_read_only(name)
        self._ros_parameters.undeclare(name)

    def _ros_not_declared(self, names: str | list[str]) -> ParameterNotDeclaredException:
        """Make the error for names that nobody declared; it suggests similar names that are declared."""
        from difflib import get_close_matches

        asked = [names] if isinstance(names, str) else names
        known = [known for name in asked for known in get_close_matches(name, self._ros_parameters, n=1)]
        hint = did_you_mean(known) or f'call declare_parameter({asked[0]!r}, …) before, with a default value'
        return ParameterNotDeclaredException(names, hint)

    def has_parameter(self, name: str) -> bool:
        """True if the parameter is declared."""
        return name in self._ros_parameters

    # -- reading -------------------------------------------------------------------------------------------

    def get_parameter(self, name: str) -> Parameter:
        """Return a parameter; raises ParameterNotDeclaredException or ParameterUninitializedException."""
        found = self._ros_parameters.get(name)
        if found is None:
            self._ros_refuse_undeclared(name)
            return Parameter(name)
        if self._ros_parameters.is_uninitialized(found):
            raise ParameterUninitializedException(name)
        return found

    def get_parameters(self, names: Sequence[str]) -> list[Parameter]:
        """Return several parameters; raises as get_parameter does."""
        return [self.get_parameter(name) for name in names]

    def get_parameter_or(self, name: str, alternative_value: Parameter | None = None) -> Parameter:
        """Return a parameter, or the alternative if it is missing or has no value."""
        found = self._ros_parameters.get(name)
        if found is None or found.type_ is Type.NOT_SET:
            return alternative_value or Parameter(name)
        return found

    def get_parameters_by_prefix(self, prefix: str) -> dict[str, Parameter]:
        """Return the parameters below a prefix, by the rest of their names."""
        start = f'{prefix}{SEPARATOR}' if prefix else ''
        return {
            parameter.name[len(start) :]: parameter
            for parameter in self._ros_parameters.values()
            if parameter.name.startswith(start)
        }

    def get_parameter_type(self, name: str) -> int | Type:
        """Return the number of a parameter's type (rcl_interfaces/msg/ParameterType).

        Type.NOT_SET for an undeclared parameter, if the node allows them. Raises
        ParameterNotDeclaredException.
        """
        found = self._ros_parameters.get(name)
        if found is not None:
            return found.type_.value
        self._ros_refuse_undeclared(name)
        return Type.NOT_SET

    def get_parameter_types(self, names: Sequence[str]) -> list[int | Type]:
        """Return the types of several parameters; raises as get_parameter_type does."""
        return [self.get_parameter_type(name) for name in names]

    def describe_parameter(self, name: str) -> ParameterDescriptor:
        """Return a parameter's descriptor, an empty one for an undeclared parameter, if the node allows them.

        Raises ParameterNotDeclaredException.
        """
        descriptor = self._ros_parameters.descriptor(name)
        if descriptor is None:
            self._ros_refuse_undeclared(name)
            descriptor = Descriptor()
        return descriptor_message(descriptor)

    def describe_parameters(self, names: Sequence[str]) -> list[ParameterDescriptor]:
        """Return the descriptors of several parameters; raises as describe_parameter does."""
        return [self.describe_parameter(name) for name in names]

    def list_parameters(self, prefixes: list[str], depth: int) -> ListParametersResult:
        """Return the names at or below the prefixes (all for none), `depth` parts deep at most (0: any).

        Raises TypeError, ValueError.
        """
        from rcl_interfaces.msg import ListParametersResult

        names, heads = list_names(list(self._ros_parameters), prefixes, depth)
        return ListParametersResult(names=names, prefixes=heads)

    # -- setting -------------------------------------------------------------------------------------------

    def set_parameters(self, parameter_list: Sequence[Parameter]) -> list[SetParametersResult]:
        """Set each parameter on its own; returns one rcl_interfaces/msg/SetParametersResult for each.

        A parameter without a value undeclares a dynamically typed one. Raises ParameterNotDeclaredException,
        TypeError for anything but a Parameter.
        """
        parameters = list(parameter_list)
        outcomes = [self._ros_set([parameter]) for parameter in parameters]
        self._ros_tell_dropped(parameters, outcomes)
        return [result_message(outcome) for outcome in outcomes]

    def set_parameters_atomically(self, parameter_list: Sequence[Parameter]) -> SetParametersResult:
        """Set all parameters or none; raises as set_parameters does."""
        parameters = list(parameter_list)
        outcome = self._ros_set(parameters)
        self._ros_tell_dropped(parameters, [outcome])
        return result_message(outcome)

    def _ros_tell_dropped(self, parameters: Sequence[Parameter], outcomes: Sequence[Outcome]) -> None:
        """Warn that a set was refused, if the program's line that asked for it ignores the answer.

        `outcomes` has one item for each of the parameters, or one item for all.
        """
        refused = next((outcome for outcome in outcomes if not outcome.successful), None)
        if refused is None or refused.reason.startswith(NO_ANSWER):
            return  # a callback without an answer was logged already
        if place := dropping_place(2):
            of = parameters if len(outcomes) == 1 else [parameters[outcomes.index(refused)]]
            names = ', '.join(repr(parameter.name) for parameter in of)
            get_logger(self.handle.logger_name).warning(
                f'{names} was not set: {refused.reason}; '
                f'{_remedy(self._ros_parameters, of, refused)}{at(place)}'
            )

    def _ros_set(self, parameters: list[Parameter]) -> Outcome:
        _check_parameters(parameters)
        if self._ros_set_callbacks.before:
            parameters = self._ros_set_callbacks.prepare(parameters)
            _check_parameters(parameters)
            if not parameters:
                return NOTHING_LEFT
        undeclared = [
            parameter.name for parameter in parameters if parameter.name not in self._ros_parameters
        ]
        if undeclared and not self._ros_parameters.allow_undeclared:
            raise self._ros_not_declared(undeclared)
        outcome = self._ros_parameters.judge(parameters)
        return self._ros_change(parameters) if outcome.successful else outcome

    def _ros_change(
        self, parameters: list[Parameter], declared: Mapping[str, Descriptor] | None = None
    ) -> Outcome:
        """Ask the set callbacks, store the values, publish the event, and call the post-set callbacks."""
        outcome = self._ros_set_callbacks.judge(parameters)
        if not outcome.successful:
            return outcome
        if self.handle.destroyed:
            raise InvalidHandle
        changes = self._ros_parameters.store(parameters, declared)
        if self._ros_parameter_events is not None:
            self._ros_parameter_events.publish(changes)
        self._ros_set_callbacks.tell(parameters)
        return outcome

    def set_descriptor(
        self,
        name: str,
        descriptor: Described,
        alternative_value: ParameterValueMessage | None = None,
    ) -> ParameterValueMessage:
        """Give a parameter another descriptor, and the alternative value if its present value does not suit
        it.

        Returns its value. Neither callbacks nor /parameter_events learn of it. Raises
        ParameterNotDeclaredException, ParameterImmutableException, ParameterUninitializedException,
        InvalidParameterValueException.
        """
        parameter = self.get_parameter(name)
        if name in self._ros_parameters:
            self._ros_refuse_read_only(name)
            wanted = described(descriptor)
            parameter = _suiting(wanted, parameter, alternative_value)
            self._ros_parameters.describe(wanted, parameter)
        return parameter.get_parameter_value()

    def _ros_refuse_undeclared(self, name: str) -> None:
        if not self._ros_parameters.allow_undeclared:
            raise self._ros_not_declared(name)

    def _ros_refuse_read_only(self, name: str) -> None:
        descriptor = self._ros_parameters.descriptor(name)
        if descriptor is not None and descriptor.read_only:
            raise ParameterImmutableException(name)


def _remedy(store: ParameterTable, refused: Sequence[Parameter], outcome: Outcome) -> str:
    """Return advice for a refused set whose answer nobody reads: what to write in the program instead."""
    from goalwire.rules.parameters.fitting import explain_misfit

    if len(refused) == 1 and isinstance(outcome, WrongType):
        name = refused[0].name
        descriptor = store.descriptor(name)
        if descriptor and (better := explain_misfit(name, descriptor.type, refused[0].value)):
            return better
    return (
        "this line throws the answer away: keep it, as in 'results = …', and look at .successful and .reason "
        'of each result'
    )


def _wrong_type(parameter: Parameter, wanted: Type) -> InvalidParameterTypeException:
    """Return the error for an override of another type, with rclpy's text and a note that has an example."""
    from goalwire.rules.parameters.fitting import explain_misfit

    error = InvalidParameterTypeException(parameter, wanted.name)
    if note := explain_misfit(parameter.name, wanted, parameter.value):
        error.add_note(f'{note} where its value comes from: -p, a parameter file or parameter_overrides')
    return error


def _check_parameters(parameters: Iterable[object]) -> None:
    for parameter in parameters:
        if not isinstance(parameter, Parameter):
            example = "Parameter('speed', value=2.0)"
            if isinstance(parameter, tuple) and len(parameter) == 2:
                example = f'Parameter({parameter[0]!r}, value={parameter[1]!r})'
            raise TypeError(
                f"parameter must be instance of type '{Parameter!r}', got {parameter!r}; write {example}"
            )


def _suiting(
    descriptor: Descriptor, parameter: Parameter, alternative: ParameterValueMessage | None
) -> Parameter:
    """Return the parameter if it suits the descriptor, else one with the alternative value. Raises
    InvalidParameterValueException.
    """
    outcome = descriptor.judge(parameter)
    if not outcome.successful and alternative is not None:
        type_ = Type(alternative.type)
        parameter = Parameter(parameter.name, type_, value_of(alternative))
        outcome = descriptor.judge(parameter)
    if not outcome.successful:
        raise InvalidParameterValueException(parameter.name, parameter.value, outcome.reason)
    return parameter
