"""Python expressions over a message, for `--filter`: parsed to a tree and evaluated here, never by `eval`.

Allowed are `m` (the message), fields, indices, constants, arithmetic, comparisons, `and`, `or`, `not`, `in`,
`if … else`, lists and tuples, and the functions of FUNCTIONS. Everything else is refused, such as names that
begin with an underscore, methods and powers.

The evaluation takes little time for any message. The expression's text is short. Only numbers are multiplied,
and nothing is raised to a power, so no value is much longer than the text and the message together. `round`
takes few digits, because it raises ten to the power of their number. Functions and operators that walk
through lists and texts may visit MOST_ITEMS of their items.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

from goalwire.apps.cli.framework.outcome import CommandError, Outcome

LONGEST = 2000
"""The longest expression, in characters."""
MOST_ITEMS = 20_000_000
"""Items of lists and characters of texts that one evaluation may visit: two seconds in the worst case."""
MOST_DIGITS = 400
"""Most digits that `round` takes; a double has no more digits before or after its point."""
_ITEMS_OF_A_TEXT = 1_000_000
"""The cost of `str` of a list or message, counted in items, because of its nested parts."""

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
"""Operators that take only numbers here: applied to a text they could make a huge text."""


class Expression:
    """A compiled expression of a user."""

    def __init__(self, text: str) -> None:
        """Parse an expression. Raises CommandError if it is invalid."""
        self._text = text if len(text) <= LONGEST else text[:LONGEST] + '…'
        if len(text) > LONGEST:
            raise self._error(f'it has {len(text)} characters, and may have {LONGEST}')
        try:
            self._body = ast.parse(text.strip(), mode='eval').body
        except SyntaxError as error:
            raise self._error(f'it is not a Python expression: {error.msg}') from None
        except (RecursionError, MemoryError):
            raise self._error('it is nested too deeply') from None
        except ValueError:
            raise self._error('it contains a character that is not allowed in an expression') from None

    def __call__(self, message: Any) -> bool:
        """Return whether the expression holds for a message; raises CommandError, also if it takes too
        long.
        """
        try:
            return _Evaluation(message, self._error).holds(self._body)
        except RecursionError:
            raise self._error('it is nested too deeply') from None

    def _error(self, problem: str) -> CommandError:
        return CommandError(
            Outcome.BAD_VALUE,
            f"--filter '{self._text}': {problem}",
            'write it like: m.data > 3 and "x" in m.name',
        )


class _Evaluation:
    """Evaluates the tree of an expression for one message."""

    def __init__(self, message: Any, error: Callable[[str], CommandError]) -> None:
        self._message = message
        self._error = error
        self._items_left = MOST_ITEMS

    def holds(self, tree: ast.expr) -> bool:
        """Return whether an expression is true."""
        value = self.value(tree)
        try:
            return bool(value)
        except ValueError:  # bool() refuses a numpy array
            problem = f'{_source(tree)} is a list: write all({_source(tree)}) or any({_source(tree)})'
            raise self._error(problem) from None

    def value(self, tree: ast.expr) -> Any:
        """Return the value of an expression."""
        match tree:
            case ast.Constant():
                return tree.value
            case ast.Name(id='m'):
                return self._message
            case ast.Attribute(attr=name) if not name.startswith('_'):
                return self._field(tree.value, name)
            case ast.Subscript():
                return self._item(tree)
            case ast.Slice():
                ends = (tree.lower, tree.upper, tree.step)
                return slice(*(None if part is None else self.value(part) for part in ends))
            case ast.List() | ast.Tuple():
                return [self.value(part) for part in tree.elts]
            case ast.BoolOp(op=ast.And()):
                return all(self.holds(part) for part in tree.values)
            case ast.BoolOp():
                return any(self.holds(part) for part in tree.values)
            case ast.UnaryOp(op=ast.Not()):
                return not self.holds(tree.operand)
            case ast.UnaryOp() if type(tree.op) in _OPERATORS:
                return self._attempt(tree, _OPERATORS[type(tree.op)], self.value(tree.operand))
            case ast.BinOp() if type(tree.op) in _OPERATORS:
                return self._calculate(tree)
            case ast.Compare():
                return self._compare(tree)
            case ast.IfExp():
                return self.value(tree.body if self.holds(tree.test) else tree.orelse)
            case ast.Call(func=ast.Name(id=name), keywords=[]) if name in FUNCTIONS:
                return self._call(tree, name)
        raise self._error(f'{ast.unparse(tree)!r} is not allowed here')

    def _field(self, owner: ast.expr, name: str) -> Any:
        """Return a field of a message. Other attributes are refused."""
        value = self.value(owner)
        if not hasattr(value, 'get_fields_and_field_types'):
            raise self._error(f'{_source(owner)} is {_kind(value)}, which has no field {name!r}')
        fields = value.get_fields_and_field_types()
        if name not in fields:
            there = ', '.join(fields) or 'none'
            raise self._error(f'{_source(owner)} has no field {name!r}; its fields are: {there}')
        return getattr(value, name)

    def _item(self, tree: ast.Subscript) -> Any:
        value, index = self.value(tree.value), self.value(tree.slice)
        try:
            return self._attempt(tree, operator.getitem, value, index)
        except IndexError:
            problem = f'{_source(tree.value)} has {len(value)} items, and no item {index}'
            raise self._error(problem) from None

    def _calculate(self, tree: ast.BinOp) -> Any:
        left, right = self.value(tree.left), self.value(tree.right)
        if isinstance(tree.op, _NUMBERS) and not all(isinstance(each, int | float) for each in (left, right)):
            raise self._error('only numbers are multiplied')
        return self._attempt(tree, _OPERATORS[type(tree.op)], left, right)

    def _compare(self, tree: ast.Compare) -> Any:
        left = self.value(tree.left)
        found: Any = True
        for at, (kind, part) in enumerate(zip(tree.ops, tree.comparators, strict=True)):
            right = self.value(part)
            found = self._attempt(tree, _OPERATORS[type(kind)], left, right)
            if at < len(tree.ops) - 1 and not found:
                return False
            left = right
        return found

    def _call(self, tree: ast.Call, name: str) -> Any:
        values = [self.value(part) for part in tree.args]
        if (
            name == 'round'
            and len(values) > 1
            and isinstance(values[1], int)
            and abs(values[1]) > MOST_DIGITS
        ):
            raise self._error(f'round takes from {-MOST_DIGITS} to {MOST_DIGITS} digits, not {values[1]}')
        if name == 'str' and any(not isinstance(each, int | float | str) for each in values):
            self._visit(_ITEMS_OF_A_TEXT)
        if name == 'sum' and any(isinstance(each, list) for each in values[1:]):
            raise self._error('sum takes only numbers')  # sum() copies a list for each item
        return self._attempt(tree, FUNCTIONS[name], *values)

    def _attempt(self, tree: ast.expr, function: Callable[..., Any], *values: Any) -> Any:
        """Call a function, and turn its errors into sentences that name the part of the expression."""
        self._visit(sum(len(each) for each in values if hasattr(each, '__len__')))
        try:
            return function(*values)
        except ZeroDivisionError:
            raise self._error(f'{_source(tree)} divides by zero') from None
        except OverflowError:
            raise self._error(f'{_source(tree)} is too large a number') from None
        except (TypeError, ValueError, AttributeError):
            kinds = ' and '.join(map(_kind, values)) or 'nothing'
            raise self._error(f'{_source(tree)} cannot be evaluated with {kinds}') from None

    def _visit(self, items: int) -> None:
        self._items_left -= items
        if self._items_left < 0:
            raise self._error(f'it visits more than {MOST_ITEMS:,} items of lists and texts')


def _source(tree: ast.expr) -> str:
    return f"'{ast.unparse(tree)}'"


def _kind(value: object) -> str:
    """Return the kind of a value in words."""
    if hasattr(value, 'get_fields_and_field_types'):
        return 'a message'
    for kinds, name in _KINDS:
        if isinstance(value, kinds):
            return name
    return 'a list' if hasattr(value, '__len__') else f'a {type(value).__name__}'


_KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    (bool, 'true or false'),
    ((int, float), 'a number'),
    (str, 'a text'),
    (type(None), 'nothing'),
    (slice, 'a part'),
)
