"""Conditions under which actions are carried out."""

from __future__ import annotations

from goalwire.errors import InvalidConditionExpressionError
from goalwire.launching.model import Condition, LaunchContext, SomeSubstitutions
from goalwire.launching.values import (
    describe_text,
    evaluate_condition_expression,
    normalize_to_list_of_substitutions,
    perform_substitutions,
)

__all__ = [
    'AndCondition',
    'IfCondition',
    'InvalidConditionExpressionError',
    'LaunchConfigurationEquals',
    'LaunchConfigurationNotEquals',
    'OrCondition',
    'UnlessCondition',
    'evaluate_condition_expression',
]


class IfCondition(Condition):
    """True if a text says true or 1."""

    def __init__(self, predicate_expression: SomeSubstitutions) -> None:
        super().__init__(predicate=self._holds)
        self._expression = normalize_to_list_of_substitutions(predicate_expression)

    def _holds(self, context: LaunchContext) -> bool:
        return evaluate_condition_expression(context, self._expression)

    def describe(self) -> str:
        return f'{type(self).__name__}({describe_text(self._expression)})'


class UnlessCondition(IfCondition):
    """True if a text says false or 0."""

    def _holds(self, context: LaunchContext) -> bool:
        return not super()._holds(context)


class LaunchConfigurationEquals(Condition):
    """True if a launch configuration has the expected value; None expects that it is not set."""

    def __init__(self, launch_configuration_name: str, expected_value: SomeSubstitutions | None) -> None:
        super().__init__(predicate=self._holds)
        self._name = launch_configuration_name
        self._expected = (
            None if expected_value is None else normalize_to_list_of_substitutions(expected_value)
        )

    def _holds(self, context: LaunchContext) -> bool:
        wanted = None if self._expected is None else perform_substitutions(context, self._expected)
        found: str | None = context.launch_configurations.get(self._name)
        return found == wanted

    def describe(self) -> str:
        wanted = 'None' if self._expected is None else describe_text(self._expected)
        return f"{type(self).__name__}('{self._name}', {wanted})"


class LaunchConfigurationNotEquals(LaunchConfigurationEquals):
    """True if a launch configuration has another value or is not set."""

    def _holds(self, context: LaunchContext) -> bool:
        return not super()._holds(context)


class AndCondition(Condition):
    """True if all conditions are true. Conditions after the first false condition are not evaluated."""

    def __init__(self, *conditions: Condition) -> None:
        super().__init__(predicate=lambda context: all(item.evaluate(context) for item in conditions))


class OrCondition(Condition):
    """True if one of the conditions is true."""

    def __init__(self, *conditions: Condition) -> None:
        super().__init__(predicate=lambda context: any(item.evaluate(context) for item in conditions))
