"""Python expressions over a message, for `--filter`: read as a tree and worked out here, never by `eval`.

What there is: `m` (the message), fields, indices, constants, arithmetic, comparisons, `and`, `or`, `not`,
`in`, `if … else`, lists and tuples, and the functions of FUNCTIONS. Everything else is refused: names that
begin with an underscore, methods, powers.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from goalwire.cli.outcome import CommandError, Outcome

FUNCTIONS: dict[str, Callable[..., Any]] = {
    each.__name__: each for each in (abs, all, any, bool, float, int, len, max, min, round, sorted, str, sum)
}
_OPERATORS: dict[type[ast.AST], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda item, items: item in items,
    ast.NotIn: lambda item, items: item not in items,
    ast.Not: operator.not_,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}
_NUMBERS = (ast.Mult, ast.Mod)
"""Operators that could make endless texts of a text."""


class Expression:
    """An expression of a user's."""

    def __init__(self, text: str) -> None:
        """Raises CommandError for what is no expression."""
        self._text = text
        try:
            self._body = ast.parse(text, mode='eval').body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise self._error(f'it is no Python expression: {getattr(error, "msg", error)}') from None

    def __call__(self, message: Any) -> Any:
        """Work it out for a message; raises CommandError."""
        try:
            return self._value(self._body, message)
        except CommandError:
            raise
        except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError) as error:
            raise self._error(str(error)) from None

    def _error(self, problem: str) -> CommandError:
        return CommandError(
            Outcome.BAD_VALUE,
            f"--filter '{self._text}': {problem}",
            'write it like: m.data > 3 and "x" in m.name',
        )

    def _value(self, tree: ast.expr, message: Any) -> Any:
        def value(part: ast.expr) -> Any:
            return self._value(part, message)

        match tree:
            case ast.Constant():
                return tree.value
            case ast.Name(id='m'):
                return message
            case ast.Attribute(attr=name) if not name.startswith('_'):
                return self._field(value(tree.value), name)
            case ast.Subscript():
                return value(tree.value)[value(tree.slice)]
            case ast.Slice():
                ends = (tree.lower, tree.upper, tree.step)
                return slice(*(None if part is None else value(part) for part in ends))
            case ast.List() | ast.Tuple():
                return [value(part) for part in tree.elts]
            case ast.BoolOp(op=ast.And()):
                return all(value(part) for part in tree.values)
            case ast.BoolOp():
                return any(value(part) for part in tree.values)
            case ast.UnaryOp() if type(tree.op) in _OPERATORS:
                return _OPERATORS[type(tree.op)](value(tree.operand))
            case ast.BinOp() if type(tree.op) in _OPERATORS:
                left, right = value(tree.left), value(tree.right)
                if isinstance(tree.op, _NUMBERS) and not all(
                    isinstance(each, int | float) for each in (left, right)
                ):
                    raise self._error('only numbers are multiplied')
                return _OPERATORS[type(tree.op)](left, right)
            case ast.Compare():
                return self._compare(tree, message)
            case ast.IfExp():
                return value(tree.body) if value(tree.test) else value(tree.orelse)
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in FUNCTIONS:
                return FUNCTIONS[name](*(value(part) for part in tree.args))
        raise self._error(f'{ast.unparse(tree)!r} is not to be used here')

    def _field(self, value: Any, name: str) -> Any:
        """Return a field of a message; other attributes are none of an expression's business."""
        if not hasattr(value, 'get_fields_and_field_types'):
            raise self._error(f"'{name}' is asked of what is no message")
        return getattr(value, name)

    def _compare(self, tree: ast.Compare, message: Any) -> bool:
        left = self._value(tree.left, message)
        for kind, part in zip(tree.ops, tree.comparators, strict=True):
            right = self._value(part, message)
            if not _OPERATORS[type(kind)](left, right):
                return False
            left = right
        return True
