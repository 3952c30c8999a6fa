"""The Python source of a message class: like rosidl's, but with a fast constructor.

In the source, `_self` and all imported names start with an underscore, because names of fields never do.
"""

from __future__ import annotations

from goalwire.idl.model import Field, MessageDefinition, Shape
from goalwire.idl.runtime import DTYPES, TYPECODES, UNSET, pack_array, to_array, to_ndarray
from goalwire.records import record

_ZEROS = {'bool': False, 'byte': b'\0', 'string': '', 'wstring': ''}


@record
class _Slot:
    """A field in the generated source: its default in the signature, and expressions for its stored value."""

    name: str
    signature: str  # the default of the keyword argument
    fresh: str  # an expression that makes a default; '' if `signature` itself is stored
    convert: str  # an expression that converts a given value, which replaces `{}`
    is_packed: bool = False  # the slot holds bytes until the field is first read
    converts_first: bool = False  # conversion precedes checks, as rosidl does for number sequences

    def stored(self) -> str:
        return self._given(self.convert.format(self.name))

    def checked(self) -> str:
        if self.is_packed:
            default = f'_unpack_array(_dtype_{self.name}, {self.fresh})'
            return f'{default} if {self.name} is _UNSET else {self.name}'
        return self.stored() if self.converts_first else self._given(self.name)

    def _given(self, given: str) -> str:
        return f'{self.fresh} if {self.name} is _UNSET else {given}' if self.fresh else given


def class_source(
    message: MessageDefinition, classes: dict[str, type], *, checks: bool
) -> tuple[str, dict[str, object]]:
    """Return a message class's source and the names that it needs; `classes`: nested classes by full name.

    With `checks` the class's messages check their fields, unless check_fields=False is given.
    """
    names: dict[str, object] = {'_UNSET': UNSET}
    slots = [_slot(field, names) for field in message.fields]
    names.update({_class_name(full_name): cls for full_name, cls in classes.items()})
    slot_names = [*(f'_{slot.name}' for slot in slots), '_check_fields']
    lines = [
        f'class {message.name}(metaclass=_Metaclass):',
        '    __doc__ = _documentation',
        f'    __slots__ = {slot_names!r}',
        '',
        *_constructor(slots, checks=checks),
        *_equality(message.fields),
    ]
    for slot in slots:
        lines += _property(slot)
    return '\n'.join(lines) + '\n', names


def single_default(field: Field) -> object:
    """Return the default of a field that holds one primitive value."""
    if field.default is not None:
        return field.default
    return _ZEROS.get(field.type.base, 0.0 if field.type.base.startswith('float') else 0)


def copy_default(field: Field) -> object:
    """Return a field's own default as a value that the caller may change."""
    values = field.default
    if not isinstance(values, tuple):
        return values
    if field.type.is_number and field.type.is_sequence:
        return to_array(TYPECODES[field.type.base], values)  # type: ignore[arg-type]
    if field.type.is_number:
        return to_ndarray(DTYPES[TYPECODES[field.type.base]], values)
    return list(values)


def _class_name(full_name: str) -> str:
    return full_name.replace('/', '__')


def _slot(field: Field, names: dict[str, object]) -> _Slot:
    type_, name = field.type, field.name
    default = field.default
    if type_.shape is Shape.SINGLE:
        if type_.is_message:
            return _Slot(name, '_UNSET', f'{_class_name(type_.base)}()', '{}')
        names[f'_default_{name}'] = single_default(field)
        return _Slot(name, f'_default_{name}', '', '{}')
    if type_.is_number and type_.is_sequence:
        code = TYPECODES[type_.base]
        initial = ''
        if default:
            names[f'_default_{name}'], initial = default, f', _default_{name}'
        convert = f'_to_array({code!r}, {{}}, {name!r})'
        return _Slot(name, '_UNSET', f'_array({code!r}{initial})', convert, converts_first=True)
    if type_.is_number:
        names[f'_default_{name}'] = pack_array(type_.base, type_.capacity, default)  # type: ignore[arg-type]
        convert = f'_to_fixed(_dtype_{name}, {{}}, {name!r})'
        return _Slot(name, '_UNSET', f'_default_{name}', convert, is_packed=True)
    if default is not None:
        names[f'_default_{name}'] = default
        return _Slot(name, '_UNSET', f'_list(_default_{name})', '{}')
    if type_.shape is not Shape.ARRAY:
        return _Slot(name, '_UNSET', '[]', '{}')
    item = f'{_class_name(type_.base)}()' if type_.is_message else repr(_ZEROS[type_.base])
    return _Slot(name, '_UNSET', f'[{item} for _ in _range({type_.capacity})]', '{}')


def _constructor(slots: list[_Slot], *, checks: bool) -> list[str]:
    keywords = ''.join(f'{slot.name}={slot.signature}, ' for slot in slots)
    # Rare arguments, such as check_fields, are in _rest, so that the usual call makes only one test.
    return [
        f'    def __init__(_self, {"*, " if slots else ""}{keywords}**_rest):',
        '        _self._check_fields = False',
        '        if _rest or _CHECK_FIELDS:' if checks else '        if _rest:',
        '            _self._check_fields = _checks_asked(_self, _rest, _CHECK_FIELDS)',
        '            if _self._check_fields:',
        *(f'                _self.{slot.name} = {slot.checked()}' for slot in slots),
        '                return',
        *(f'        _self._{slot.name} = {slot.stored()}' for slot in slots),
        '',
    ]


def _equality(fields: tuple[Field, ...]) -> list[str]:
    def compare(field: Field) -> str:
        if field.type.is_number and field.type.shape is Shape.ARRAY:
            return f'_arrays_equal(_self.{field.name}, _other.{field.name})'
        return f'_self._{field.name} == _other._{field.name}'

    return [
        '    def __eq__(_self, _other):',
        '        if not _isinstance(_other, _self.__class__):',
        '            return False',
        f'        return {" and ".join(map(compare, fields)) or True}',
        '',
    ]


def _unpacking(name: str) -> list[str]:
    """Return the lines that turn the bytes in a slot into a fixed primitive array; see idl/runtime.py."""
    return [
        f'        _kept = _self._{name}',
        '        if _type(_kept) is _bytes:',
        f'            _self._{name} = _unpack_array(_dtype_{name}, _kept)',
    ]


def _property(slot: _Slot) -> list[str]:
    return [
        '    @_property',
        f'    def {slot.name}(_self):',
        f'        """Message field {slot.name!r}."""',
        *(_unpacking(slot.name) if slot.is_packed else ()),
        f'        return _self._{slot.name}',
        '',
        f'    @{slot.name}.setter',
        f'    def {slot.name}(_self, _value):',
        '        if _self._check_fields:',
        f'            _self._{slot.name} = _check_{slot.name}(_value)',
        '        else:',
        f'            _self._{slot.name} = {slot.convert.format("_value")}',
        '',
    ]
