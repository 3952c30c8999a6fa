"""launch.conditions: conditions under which actions are carried out."""

from goalwire.errors import InvalidConditionExpressionError
from goalwire.launching.aliases import add_modules
from goalwire.launching.conditions import (
    AndCondition,
    IfCondition,
    LaunchConfigurationEquals,
    LaunchConfigurationNotEquals,
    OrCondition,
    UnlessCondition,
    evaluate_condition_expression,
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

add_modules(
    __name__,
    {
        'InvalidConditionExpressionError': 'invalid_condition_expression_error',
        'evaluate_condition_expression': 'evaluate_condition_expression_impl',
    },
)
