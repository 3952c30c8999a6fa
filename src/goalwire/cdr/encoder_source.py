"""Generates an encoder's source: one function per message class, one more per class inside its sequences.

Nested messages are flattened. Successive fields of fixed size, with at most one string among them, form a
run, which one call of a precompiled struct packs. Types and ranges are checked during the encoding. If a
check fails, cdr/explain.py finds out for which field.
"""

from __future__ import annotations

import sys
from array import array
from struct import Struct

from goalwire.cdr import layout, writing
from goalwire.cdr.explain import raising
from goalwire.cdr.layout import COUNT, EMPTY, HEADER_SIZE, TEXT, Item, Leaf
from goalwire.idl.model import FLOATS, Shape
from goalwire.idl.runtime import DTYPES, TYPECODES

_HELPERS: dict[str, object] = {
    'array': array,
    'bools': writing.bools,
    'dtypes': writing.NumpyTypes(),
    'fixed_numbers': writing.fixed_numbers,
    'little_endian': writing.little_endian,
    'numbers': writing.numbers,
    'octets': writing.octets,
    'put_texts': writing.put_texts,
    'put_wide_texts': writing.put_wide_texts,
    'refuse': writing.refuse,
    'require': writing.require,
    'wide': writing.wide,
}


def encoder_source(cls: type, *, outcome: str = '') -> tuple[str, dict[str, object]]:
    """Return the source of `encode(m0) -> bytes` for a message class, and the names that it needs.

    With `outcome`, `encode` returns the value of that expression instead. In it, `out` is a list of buffers
    that together are these bytes, and `at` their number. If a sequence of numbers is an array, or a
    memoryview of the right type, it is itself one of the buffers.
    """
    module = _Module()
    single = layout.texts_inside(cls) in (0, 1) and not outcome
    body = _Body(module, at=0, single=single, outcome=outcome)
    body.message(cls, 'm0')
    lines = [
        'def encode(m0):',
        '    try:',
        *(f'        {line}' for line in body.finish()),
        '    except Exception as error:',
        '        failure = explain(m0, error)',
        *raising('m0'),
    ]
    return '\n'.join([*module.lines, *lines]) + '\n', module.names


class _Module:
    """The functions of one generated encoder, and the names that they use."""

    def __init__(self) -> None:
        self.names: dict[str, object] = dict(_HELPERS)
        self.lines: list[str] = []
        self._loops: dict[type, str] = {}

    def name(self, prefix: str, value: object) -> str:
        name = f'{prefix}{len(self.names)}'
        self.names[name] = value
        return name

    def loop(self, cls: type) -> str:
        """Return the name of the generated function that encodes a sequence of messages of a class."""
        if cls not in self._loops:
            self._loops[cls] = name = f'put_{cls.__name__}_{len(self._loops)}'
            body = _Body(self, at=None, single=False)
            body.message(cls, 'm0')
            fixed = layout.stride(body.items) if layout.texts_inside(cls) == 0 else None
            self.lines += [
                f'def {name}(messages, add, at):',
                *(body.block(*fixed) if fixed else body.parts()),
                '',
            ]
        return self._loops[cls]


class _Body:
    """Generates the statements that encode one message; `at` is the offset of its first byte, or None if it
    varies.
    """

    def __init__(self, module: _Module, at: int | None, *, single: bool, outcome: str = '') -> None:
        self.lines: list[str] = []
        self._module = module
        self._first = at is not None
        self._single = single
        self._outcome = outcome or "b''.join(out)"
        self._count = 0
        self.items: list[Item] = []
        self._arguments: list[str] = []
        self._floats: list[str] = []
        self._text_size = ''
        if self._first and not single:
            self.lines += ['out = []', 'add = out.append']

    def finish(self) -> list[str]:
        self.flush()
        if not self._single:
            self.lines.append(f'return {self._outcome}')
        return self.lines

    def message(self, cls: type, variable: str) -> None:
        known = self._module.name('Class', cls)
        self.lines.append(f'if type({variable}) is not {known}: require({known}, {variable})')
        if not layout.leaves(cls):
            self.items.append(EMPTY)
        for leaf in layout.leaves(cls):
            self._leaf(leaf, f'{variable}._{leaf.name}')

    def parts(self) -> list[str]:
        """Return the source of a function's body that encodes each message of a sequence into its own
        buffers.
        """
        self.flush()
        return ['    for m0 in messages:', *(f'        {line}' for line in self.lines), '    return at']

    def block(self, run: Struct, alignment: int) -> list[str]:
        """Return the source of a function's body that encodes messages of fixed size into one
        common buffer.
        """
        self._check_floats()
        pack = self._module.name('run', run.pack_into)
        return [
            '    if not messages: return at',
            f'    place = ({HEADER_SIZE} - at) % {alignment}',
            f'    block = bytearray(place + len(messages) * {run.size})',
            '    add(block); at += len(block)',
            '    for m0 in messages:',
            *(f'        {line}' for line in self.lines),
            f'        {pack}(block, place, {", ".join(self._arguments)}); place += {run.size}',
            '    return at',
        ]

    def flush(self) -> None:
        """Add the statements that pack the collected run of fields."""
        self._check_floats()
        if self.items or self._first:
            self._pack()
        self.items, self._arguments, self._floats, self._text_size = [], [], [], ''

    def _check_floats(self) -> None:
        if self._floats:
            kinds = ' is '.join(f'type({name})' for name in self._floats)
            self.lines.append(f'if not ({kinds} is float): require(float, {", ".join(self._floats)})')

    def _pack(self) -> None:
        prefix = 'xBxx' if self._first else ''  # the header: 00 01 00 00, CDR in little endian
        arguments = ', '.join(['1', *self._arguments] if self._first else self._arguments)
        if self._text_size:
            table = self._module.name('run', writing.TextPackers(self.items, prefix))
            key = f'{self._text_size} << 3' + ('' if self._first else ' | at & 7')
            call = f'{table}[{key}]({arguments})'
        elif self._first:
            run = layout.run_struct(self.items, 0, prefix=prefix)
            call = f'{self._module.name("run", run.pack)}({arguments})'
        else:
            call = f'{self._module.name("run", writing.plain_packers(self.items))}[at & 7]({arguments})'
        if self._single:
            self.lines.append(f'return {call}')
        else:
            self.lines += [
                f'part = {call}',
                'add(part)',
                'at = len(part)' if self._first else 'at += len(part)',
            ]
        self._first = False

    def _variable(self, expression: str) -> str:
        self._count += 1
        name = f'v{self._count}'
        self.lines.append(f'{name} = {expression}')
        return name

    def _leaf(self, leaf: Leaf, expression: str) -> None:
        if leaf.type.shape is not Shape.SINGLE:
            self._many(leaf, expression)
        elif leaf.cls is not None:
            self.message(leaf.cls, self._variable(expression))
        elif leaf.type.is_string:
            self._text(leaf, expression)
        else:
            self._primitive(leaf.type.base, expression)

    def _primitive(self, base: str, expression: str) -> None:
        if base in FLOATS:
            expression = self._variable(expression)
            self._floats.append(expression)
        elif base == 'bool':
            expression = self._variable(expression)
            self.lines.append(f'if {expression} is not True and {expression} is not False: refuse()')
        self.items.append(Item.of(base))  # struct refuses all values but integers in range
        self._arguments.append(expression)

    def _text(self, leaf: Leaf, expression: str) -> None:
        if self._text_size:
            self.flush()
        limit = leaf.type.string_capacity
        text = self._variable(expression)
        if leaf.type.base == 'wstring':
            data = self._variable(f'wide({text})')
            size, count = self._variable(f'len({data})'), self._variable(f'len({data}) >> 2')
            if limit:
                self.lines.append(f'if {count} > {limit}: refuse()')
        else:
            self.lines.append(f'if type({text}) is not str: require(str, {text})')
            data = self._variable(f'{text}.encode()')
            size = count = self._variable(f'len({data}) + 1')
            self.lines.append(f'if 0 in {data}{f" or {size} > {limit + 1}" if limit else ""}: refuse()')
        self.items += [COUNT, TEXT]
        self._arguments += [count, data]
        self._text_size = size

    def _many(self, leaf: Leaf, expression: str) -> None:
        value = self._variable(expression)
        if leaf.type.is_number and leaf.type.shape is Shape.ARRAY:
            self._fixed_numbers(leaf, value)
        elif leaf.type.is_number:
            self._numbers(leaf, value)
        elif leaf.type.base in ('bool', 'byte'):
            self._bytes(leaf, value)
        else:
            self._length(leaf, value)
            self.flush()
            if leaf.cls is not None:
                self.lines.append(f'at = {self._module.loop(leaf.cls)}({value}, add, at)')
            else:
                put = 'put_wide_texts' if leaf.type.base == 'wstring' else 'put_texts'
                self.lines.append(f'at = {put}({value}, add, at, {leaf.type.string_capacity})')

    def _length(self, leaf: Leaf, value: str) -> str:
        """Add the check of a field's number of values, and for a sequence add the number to the run."""
        size = self._variable(f'len({value})')
        capacity = leaf.type.capacity
        if leaf.type.shape is Shape.ARRAY:
            self.lines.append(f'if {size} != {capacity}: refuse()')
        else:
            if leaf.type.shape is Shape.BOUNDED:
                self.lines.append(f'if {size} > {capacity}: refuse()')
            self.items.append(COUNT)
            self._arguments.append(size)
        return size

    def _fixed_numbers(self, leaf: Leaf, value: str) -> None:
        size, capacity = layout.SIZES[leaf.type.base], leaf.type.capacity
        known = f'dtypes[{wire_dtype(leaf.type.base)!r}]'  # numpy has one dtype object for each native type
        self.lines += [
            f'if type({value}) is bytes:',
            f'    if len({value}) != {size * capacity}: refuse()',
            f'elif {value}.dtype is {known} and {value}.size == {capacity}: {value} = {value}.tobytes()',
            f'else: {value} = fixed_numbers({value}, {known}, {capacity}).tobytes()',
        ]
        self.items.append(Item.block(size * capacity, size))
        self._arguments.append(value)

    def _numbers(self, leaf: Leaf, value: str) -> None:
        code, size = TYPECODES[leaf.type.base], layout.SIZES[leaf.type.base]
        self.lines += [
            f'if type({value}) is not array or {value}.typecode != {code!r}:',
            f'    {value} = numbers({code!r}, {value})',
        ]
        length = self._length(leaf, value)
        self.flush()
        self.lines.append(f'if {length}:')
        if size == 8:  # behind the length, `at` is a multiple of 4
            self.lines.append("    if not at & 7: add(b'\\0\\0\\0\\0'); at += 4")
        data = value if sys.byteorder == 'little' else f'little_endian({value})'
        self.lines.append(f'    add({data}); at += {length} * {size}')

    def _bytes(self, leaf: Leaf, value: str) -> None:
        convert = 'bools' if leaf.type.base == 'bool' else 'octets'
        data = self._variable(f'{convert}({value})')
        length = self._length(leaf, data)
        if leaf.type.shape is Shape.ARRAY:
            self.items.append(Item.block(leaf.type.capacity, 1))
            self._arguments.append(data)
        else:
            self.flush()
            self.lines.append(f'add({data}); at += {length}')


def wire_dtype(base: str) -> str:
    """Return numpy's name of a number type on the wire, such as '<f8' or '|u1'."""
    name = DTYPES[TYPECODES[base]]
    size = layout.SIZES[base]
    return f'{"|" if size == 1 else "<"}{name[0]}{size}'


assert HEADER_SIZE == 4
