"""Generates a decoder's source: one function per message class, one more per class inside its sequences.

Values are read run by run into variables; a run is a sequence of fields of fixed size, read by one call of
struct. The message objects are made last, without calling their constructors. Before anything is allocated
for a sequence, its length is compared with the bytes that are left. Bytes after a message are ignored, as in
ROS 2: `rmw_serialize` reports an estimated size, so messages from relays and bags may have some bytes more.
"""

from __future__ import annotations

import os
from array import array
from struct import Struct

from goalwire.cdr import layout, reading
from goalwire.cdr.explain import raising
from goalwire.cdr.layout import COUNT, EMPTY, HEADER_SIZE, Item, Leaf
from goalwire.idl.model import Shape
from goalwire.idl.runtime import DTYPES, TYPECODES, unpack_array

_HELPERS: dict[str, object] = {
    'BOOLS': reading.BOOLS,
    'array': array,
    'bools': reading.bools,
    'new': object.__new__,
    'numbers': reading.numbers,
    'octets': reading.octets,
    'refuse': reading.refuse,
    'swapped': reading.swap,
    'text': reading.text,
    'texts': reading.texts,
    'unpack_array': unpack_array,
    'wide_text': reading.wide_text,
    'wide_texts': reading.wide_texts,
}
_BYTE = Item('B', 1, 1)


def decoder_source(cls: type, order: str, *, view: bool) -> tuple[str, dict[str, object]]:
    """Return the source of `decode(data)` for a message class and the names that it needs.

    `order` is '<' or '>'; `view` is True if data is a memoryview, not bytes. Data with a header of
    another kind is given to `otherwise(data)`.
    """
    module = _Module(order, view=view)
    body = _Body(module, first=True)
    empty = not layout.leaves(cls)  # without fields: some peers leave out the padding byte
    root = body.message(cls, add_empty=not empty)
    body.flush()
    lines = [
        'def decode(data):',
        '    try:',
        *(f'        {line}' for line in body.lines),
        *(f'        {line}' for line in body.making),
        f'        return {root}',
        '    except Exception as error:',
        '        failure = explain(data, error)',
        *raising('data'),
    ]
    if not view:
        lines.insert(1, '    if type(data) is not bytes: return otherwise(data)')
    return '\n'.join([*module.lines, *lines]) + '\n', module.names


class _Module:
    """The functions of one generated decoder, and the names that they use."""

    def __init__(self, order: str, *, view: bool) -> None:
        self.order = order
        self.view = view
        self.names: dict[str, object] = dict(_HELPERS)
        self.lines: list[str] = []
        self._loops: dict[type, str] = {}

    def name(self, prefix: str, value: object) -> str:
        name = f'{prefix}{len(self.names)}'
        self.names[name] = value
        return name

    def loop(self, cls: type) -> str:
        """Return the name of the generated function that reads a sequence of messages of a class."""
        if cls not in self._loops:
            self._loops[cls] = name = f'get_{cls.__name__}_{len(self._loops)}'
            body = _Body(self, first=False)
            root = body.message(cls, add_empty=True)
            fixed = layout.stride(body.items, self.order) if layout.texts_inside(cls) == 0 else None
            self.lines += [
                f'def {name}(data, at, count):',
                f'    if count * {layout.minimum_size(cls)} > len(data) - at: refuse()',
                '    messages = []',
                '    add = messages.append',
                *(body.block(*fixed) if fixed else body.parts()),
                f'        add({root})',
                '    return messages, at',
                '',
            ]
        return self._loops[cls]


class _Body:
    """Generates the statements that read one message: those in `lines` fill variables, those in `making` make
    objects.
    """

    def __init__(self, module: _Module, *, first: bool) -> None:
        self.lines: list[str] = []
        self.making: list[str] = []
        self._module = module
        self._order = module.order
        self._first = first
        self._count = 0
        self.items: list[Item] = []
        self._targets: list[str] = []

    def message(self, cls: type, *, add_empty: bool) -> str:
        """Add the statements that read a message, and return the name of its variable."""
        root = self._new()
        leaves = layout.leaves(cls)
        values = [(leaf.name, self._leaf(leaf)) for leaf in leaves]
        if not leaves and add_empty:
            self.items.append(EMPTY)
        self.making.append(f'{root} = new({self._module.name("Class", cls)})')
        self.making += [f'{root}._{name} = {value}' for name, value in values]
        if '_check_fields' in getattr(cls, '__slots__', ()):
            self.making.append(
                f'{root}._check_fields = {os.environ.get("ROS_PYTHON_CHECK_FIELDS", "") == "1"}'
            )
        return root

    def parts(self) -> list[str]:
        """Return the source of a loop that reads messages run by run."""
        self.flush()
        return ['    for _ in range(count):', *(f'        {line}' for line in (*self.lines, *self.making))]

    def block(self, run: Struct, alignment: int) -> list[str]:
        """Return the source of a loop that reads messages of fixed size from one block of bytes."""
        targets = ''.join(f'{target}, ' for target in self._targets) or '_'
        read = self._module.name('run', run.iter_unpack)
        return [
            f'    if count: at += ({HEADER_SIZE} - at) % {alignment}',
            f'    end = at + count * {run.size}',
            '    if end > len(data): refuse()',
            '    block, at = data[at:end], end',
            f'    for {targets} in {read}(block):',
            *(f'        {line}' for line in self.making),
        ]

    def flush(self) -> None:
        """Add the statements that read the collected run of fields."""
        if self._first:
            run = layout.run_struct(self.items, 0, order=self._order, prefix='H2x')
            targets = ', '.join(['header', *self._targets])
            self.lines += [
                f'{targets}, = {self._module.name("run", run.unpack_from)}(data)',
                f'if header != {256 if self._order == "<" else 0}: return otherwise(data)',
                f'at = {run.size}',
            ]
        elif self.items:
            table = self._module.name('run', reading.plain_unpackers(self.items, self._order))
            self.lines.append(f'run, size = {table}[at & 7]')
            self.lines.append(
                f'{", ".join(self._targets)}, = run(data, at)' if self._targets else 'run(data, at)'
            )
            self.lines.append('at += size')
        self._first = False
        self.items, self._targets = [], []

    def _new(self) -> str:
        self._count += 1
        return f'v{self._count}'

    def _read(self, item: Item) -> str:
        self.items.append(item)
        self._targets.append(self._new())
        return self._targets[-1]

    def _assign(self, expression: str) -> str:
        name = self._new()
        self.lines.append(f'{name} = {expression}')
        return name

    def _leaf(self, leaf: Leaf) -> str:
        """Add the statements that read a field, and return the expression of its value."""
        if leaf.type.shape is not Shape.SINGLE:
            return self._many(leaf)
        if leaf.cls is not None:
            return self.message(leaf.cls, add_empty=True)
        if leaf.type.is_string:
            return self._text(leaf)
        if leaf.type.base == 'bool':
            return f'BOOLS[{self._read(_BYTE)}]'
        return self._read(Item.of(leaf.type.base))

    def _text(self, leaf: Leaf) -> str:
        size = self._read(COUNT)
        self.flush()
        limit = leaf.type.string_capacity
        if leaf.type.base == 'wstring':
            if limit:
                self.lines.append(f'if {size} > {limit}: refuse()')
            value = self._assign(f'wide_text(data, at, {size}, {self._order!r})')
            self.lines.append(f'at += 4 * {size}')
            return value
        if limit:
            self.lines.append(f'if {size} > {limit + 1}: refuse()')
        value, end = self._new(), self._assign(f'at + {size}')
        quick = f"str(data[at:{end} - 1], 'utf-8')" if self._module.view else f'data[at:{end} - 1].decode()'
        # For size 0, data[end - 1] is the last byte of the length, which is 0. Behind the data it raises
        # IndexError.
        self.lines += [
            f'{value} = text(data, at, {size}) if data[{end} - 1] else {quick}',
            f'at = {end}',
        ]
        return value

    def _many(self, leaf: Leaf) -> str:
        if leaf.type.is_number and leaf.type.shape is Shape.ARRAY:
            return self._fixed_numbers(leaf)
        convert = {'bool': 'bools', 'byte': 'octets'}.get(leaf.type.base)
        if convert and leaf.type.shape is Shape.ARRAY:
            block = self._read(Item.block(leaf.type.capacity, 1))
            return f'{convert}({block}, 0, {leaf.type.capacity})'
        length = self._length(leaf)
        self.flush()
        if leaf.type.is_number:
            return self._numbers(leaf, length)
        if convert:
            value = self._assign(f'{convert}(data, at, at + {length})')
            self.lines.append(f'at += {length}')
            return value
        value = self._new()
        if leaf.cls is not None:
            self.lines.append(f'{value}, at = {self._module.loop(leaf.cls)}(data, at, {length})')
        else:
            get = 'wide_texts' if leaf.type.base == 'wstring' else 'texts'
            limit = leaf.type.string_capacity
            self.lines.append(f'{value}, at = {get}(data, at, {length}, {self._order!r}, {limit})')
        return value

    def _length(self, leaf: Leaf) -> str:
        if leaf.type.shape is Shape.ARRAY:
            return str(leaf.type.capacity)
        length = self._read(COUNT)
        if leaf.type.shape is Shape.BOUNDED:
            self.flush()
            self.lines.append(f'if {length} > {leaf.type.capacity}: refuse()')
        return length

    def _fixed_numbers(self, leaf: Leaf) -> str:
        size, code = layout.SIZES[leaf.type.base], TYPECODES[leaf.type.base]
        block = self._read(Item.block(size * leaf.type.capacity, size))
        packed = block if self._order == '<' else f'swapped({code!r}, {block})'
        return packed if leaf.is_packed else f'unpack_array({DTYPES[code]!r}, {packed})'

    def _numbers(self, leaf: Leaf, length: str) -> str:
        code, size = TYPECODES[leaf.type.base], layout.SIZES[leaf.type.base]
        if size == 8:  # behind the length, `at` is a multiple of 4
            self.lines.append(f'if {length} and not at & 7: at += 4')
        end = self._assign(f'at + {length} * {size}')
        value = self._assign(f'numbers({code!r}, data, at, {end}, {self._order!r})')
        self.lines.append(f'at = {end}')
        return value


assert HEADER_SIZE == 4
