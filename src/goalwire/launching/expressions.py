"""Evaluates the expressions of PythonExpression and $(eval …).

Expressions are limited to arithmetic, comparisons and the functions of the modules that the file names. Names
with double underscores, lambdas and walrus are refused; of Python's own functions only FUNCTIONS are allowed.
These limits do not protect against a hostile launch file, which may run any Python anyway.
"""

from __future__ import annotations

import ast
import builtins
import importlib
from collections.abc import Iterable
from typing import Any

from goalwire.errors import SubstitutionFailure
from goalwire.launching.errors import as_sentence

FUNCTIONS = frozenset(
    [
        'abs',
        'all',
        'any',
        'bool',
        'chr',
        'dict',
        'divmod',
        'enumerate',
        'float',
        'format',
        'hash',
        'hex',
        'int',
        'isinstance',
        'len',
        'list',
        'map',
        'max',
        'min',
        'oct',
        'ord',
        'pow',
        'range',
        'repr',
        'reversed',
        'round',
        'set',
        'sorted',
        'str',
        'sum',
        'tuple',
        'zip',
    ]
)
_builtins = {name: getattr(builtins, name) for name in FUNCTIONS}
_REFUSED = (ast.Lambda, ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom)


def evaluate(expression: str, modules: Iterable[str] = ('math',)) -> str:
    """Return an expression's value as a string; with `math` in `modules`, its names need no prefix.

    Raises SubstitutionFailure if the expression is not allowed or raises an error.
    """
    names: dict[str, Any] = {'__builtins__': _builtins}
    try:
        tree = ast.parse(expression.strip(), mode='eval')
        _check(tree)
        for name in modules:
            module = importlib.import_module(name)
            if name == 'math':
                names |= {key: value for key, value in vars(module).items() if not key.startswith('_')}
            names[name.partition('.')[0]] = importlib.import_module(name.partition('.')[0])
        return str(eval(compile(tree, '<expression>', 'eval'), names))  # noqa: S307 - see the module's text
    except SubstitutionFailure:
        raise
    except Exception as error:
        raise SubstitutionFailure(f"cannot evaluate '{expression}': {_reason(error)}") from error


def _reason(error: Exception) -> str:
    if isinstance(error, NameError):
        return f'{error.args[0]} (a string needs quotes of its own)'
    return error.msg if isinstance(error, SyntaxError) else as_sentence(error)


def _check(tree: ast.AST) -> None:
    for node in ast.walk(tree):
        name = node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ''
        if isinstance(node, _REFUSED) or name.startswith('__'):
            raise SubstitutionFailure(
                f"an expression may not use {name or type(node).__name__.lower()}: '{ast.unparse(tree)}'"
            )
