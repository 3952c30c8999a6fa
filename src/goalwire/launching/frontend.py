"""Launch files in XML and YAML: both are read into a tree of tags, from which actions are made.

A tag is an `Entity`, with attributes, children and its line. Each action class reads
its attributes in `parse`; an attribute or child that it does not read is an error, reported with the line.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TextIO

import yaml

from goalwire import xml_tree
from goalwire.errors import BadLaunchValueError, InvalidFrontendLaunchFileError, LaunchError
from goalwire.files import read_regular
from goalwire.launching.conditions import IfCondition, UnlessCondition
from goalwire.launching.errors import Location, locate
from goalwire.launching.exposure import instantiate_action
from goalwire.launching.model import Action, Condition, LaunchDescription, Substitution
from goalwire.launching.notation import parse_if_substitutions, parse_substitution, replace_escaped_characters
from goalwire.launching.values import coerce_to_type, scalar_type

LARGEST = 2**24


class Entity:
    """A tag: its attributes by name, its children in order, and its position in the file."""

    def __init__(
        self,
        type_name: str,
        attributes: dict[str, Any],
        children: list[Entity],
        location: Location,
        parent: Entity | None = None,
    ) -> None:
        self._type_name = type_name
        self._attributes = attributes
        self._children = children
        self.location = location
        self.parent = parent
        self._read: set[str] = set()
        self._asked: set[str] = set()
        self._read_tags: set[str] = set()
        for child in children:
            child.parent = self

    @property
    def type_name(self) -> str:
        return self._type_name

    @property
    def children(self) -> list[Entity]:
        """All children. Reading this property marks them as read."""
        self._read_tags |= {child.type_name for child in self._children}
        return self._children

    def get_entities(self, name: str) -> list[Entity]:
        """Return the children with this tag."""
        self._read_tags.add(name)
        return [child for child in self._children if child.type_name == name]

    def get_attr(
        self, name: str, *, data_type: Any = str, optional: bool = False, can_be_str: bool = True
    ) -> Any:
        """Return an attribute's value, converted to a type; for `List[Entity]`, the children of that name.

        With `can_be_str` a text that does not fit the type stays a text: it may hold a substitution. Raises
        LaunchError for a missing attribute that is not optional, and for a value of another type.
        """
        self._asked.add(name)
        if _is_entity_list(data_type):
            found = self.get_entities(name)
            if found or optional:
                return found or None
            raise LaunchError(f'<{self._type_name}> needs <{name}> in it')
        if name not in self._attributes:
            if optional:
                return None
            raise LaunchError(f"<{self._type_name}> needs the attribute '{name}'")
        self._read.add(name)
        value = self._attributes[name]
        separator = self._attributes.get(f'{name}-sep')
        if separator is not None:
            self._read.add(f'{name}-sep')
            inner = None if data_type in (str, None) else scalar_type(data_type)[0]
            return [coerce_to_type(item, inner, can_be_str) for item in str(value).split(separator)]
        try:
            if data_type is str and not isinstance(value, str):
                return _as_text(value)
            return coerce_to_type(value, data_type, can_be_str) if isinstance(value, str) else value
        except ValueError as error:
            raise LaunchError(f"attribute '{name}' of <{self._type_name}>: {error}") from error

    def assert_entity_completely_parsed(self) -> None:
        """Raise LaunchError if there are attributes or children that were not read."""
        attributes = sorted(self._attributes.keys() - self._read)
        if attributes:
            hint = near_names(attributes, self._asked)
            raise BadLaunchValueError(
                f'`{self._type_name}` does not take {_list("attribute", attributes)}{hint}'
            )
        tags = sorted({child.type_name for child in self._children} - self._read_tags)
        if tags:
            hint = near_names(tags, self._read_tags)
            raise BadLaunchValueError(f'`{self._type_name}` does not take {_list("tag", tags)} in it{hint}')


def near_names(given: Iterable[str], known: Iterable[str]) -> str:
    """Return `; did you mean …?` with known names similar to the given ones; '' if there are none."""
    near = dict.fromkeys(
        name for item in given for name in get_close_matches(item, sorted(known), n=1, cutoff=0.6)
    )
    return f'; did you mean {" and ".join(near)}?' if near else ''


def _list(what: str, names: list[str]) -> str:
    return f'the {what}{"s" if len(names) > 1 else ""} ' + ', '.join(f"'{name}'" for name in names)


def _as_text(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return (
        str(value)
        if isinstance(value, int | float)
        else yaml.safe_dump(value, default_flow_style=True).strip()
    )


def _is_entity_list(data_type: Any) -> bool:
    inner: list[Any] = list(getattr(data_type, '__args__', ()))
    return bool(inner) and isinstance(inner[0], type) and issubclass(inner[0], Entity)


class Parser:
    """Reads launch files into launch descriptions; each derived class reads one notation (XML or YAML)."""

    endings: tuple[str, ...] = ()

    @classmethod
    def parsers(cls) -> list[type[Parser]]:
        return [XMLParser, YAMLParser]

    @classmethod
    def may_parse(cls, filename: str) -> bool:
        return any(filename.endswith(f'.{ending}') for ending in cls.endings)

    @classmethod
    def is_filename_valid(cls, filename: str) -> bool:
        return any(parser.may_parse(filename) for parser in cls.parsers())

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        return set(cls.endings)

    @classmethod
    def get_available_extensions(cls) -> list[str]:
        return ['xml', 'yaml', 'yml']

    @classmethod
    def get_file_extensions_from_parsers(cls) -> set[str]:
        return {ending for parser in cls.parsers() for ending in parser.endings}

    @classmethod
    def load(cls, file: str | os.PathLike[str] | TextIO) -> tuple[Entity, Parser]:
        """Read a file into a tree of tags. Raises InvalidFrontendLaunchFileError, with file and line."""
        if isinstance(file, str | os.PathLike):
            name, data = os.fspath(file), _contents(os.fspath(file))
        else:
            name, data = getattr(file, 'name', '<text>'), file.read().encode()
        own = [cls] if cls.endings else [parser for parser in cls.parsers() if parser.may_parse(name)]
        failures: list[Exception] = []
        for parser in own or cls.parsers():
            try:
                return parser.read(data, name), parser()
            except InvalidFrontendLaunchFileError as error:
                failures.append(error)
        raise failures[0]

    @classmethod
    def read(cls, data: bytes, name: str) -> Entity:
        """Parse a text in this class's notation into a tree of tags."""
        raise NotImplementedError

    def parse_action(self, entity: Entity) -> Action:
        """Return the action of a tag. Raises LaunchError."""
        try:
            action = instantiate_action(entity, self)
        except Exception as error:
            raise locate(error, entity.location) from error
        action.location = entity.location
        return action

    def parse_children(self, entity: Entity, skip: Iterable[str] = ()) -> list[Action]:
        """Return the actions of a tag's children."""
        skipped = set(skip)
        return [self.parse_action(child) for child in entity.children if child.type_name not in skipped]

    def parse_condition(self, entity: Entity) -> Condition | None:
        """Return the condition in a tag's `if` or `unless`, else None. Raises LaunchError if it has both."""
        yes, no = entity.get_attr('if', optional=True), entity.get_attr('unless', optional=True)
        if yes is not None and no is not None:
            raise LaunchError('`if` and `unless` cannot be used together')
        if yes is not None:
            return IfCondition(self.parse_substitution(yes))
        return None if no is None else UnlessCondition(self.parse_substitution(no))

    def parse_substitution(self, value: str) -> list[Substitution]:
        """Return the substitutions of a text with $(…) in it."""
        return parse_substitution(value)

    def parse_if_substitutions(self, value: Any) -> Any:
        """Return the value, or its substitutions if it is a text with $(…) in it."""
        return parse_if_substitutions(value)

    def escape_characters(self, value: str) -> str:
        """Return the text without the backslashes that escape characters."""
        return replace_escaped_characters(value)

    def parse_description(self, entity: Entity) -> LaunchDescription:
        """Return the description of a whole file. Raises LaunchError."""
        if entity.type_name != 'launch':
            raise _make_error(entity.location, f'the outermost tag is <launch>, not <{entity.type_name}>')
        try:
            reason = entity.get_attr('deprecated', optional=True)
            version = entity.get_attr('version', optional=True)
            if version is not None:
                str(version)
            actions = self.parse_children(entity)
            entity.assert_entity_completely_parsed()
        except Exception as error:
            raise locate(error, entity.location) from error
        return LaunchDescription(actions, deprecated_reason=reason)


def _contents(path: str) -> bytes:
    try:
        return read_regular(path, LARGEST)
    except OSError as error:
        raise InvalidFrontendLaunchFileError(f'cannot read {path}: {error.strerror}') from error


class XMLParser(Parser):
    """Reads XML: an element is a tag, with the element's attributes and children."""

    endings = ('launch.xml', 'xml')

    @classmethod
    def read(cls, data: bytes, name: str) -> Entity:
        path = _absolute(name)
        try:
            return _entity(path, xml_tree.read(data))
        except xml_tree.XmlError as error:
            raise _make_error(Location(path, error.line), f'no valid XML: {error.problem}') from error


def _entity(path: str, element: xml_tree.Element) -> Entity:
    if element.text_line is not None:
        words = element.text.strip().splitlines()[0].strip()[:60]
        raise _make_error(Location(path, element.text_line), f"text between the tags: '{words}'")
    children = [_entity(path, child) for child in element.children]
    return Entity(element.tag, dict(element.attributes), children, Location(path, element.line))


class YAMLParser(Parser):
    """Reads YAML: a mapping with one key is a tag; its value is a list of children, or maps attributes."""

    endings = ('launch.yaml', 'launch.yml', 'yaml', 'yml')

    @classmethod
    def read(cls, data: bytes, name: str) -> Entity:
        path = _absolute(name)
        try:
            node = yaml.compose(data.decode('utf-8-sig'), Loader=yaml.SafeLoader)
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            mark = getattr(error, 'problem_mark', None)
            what = ' '.join(str(getattr(error, 'problem', None) or error).split())
            begun = getattr(error, 'context_mark', None)
            if mark is not None and begun is not None and begun.line < mark.line <= data.count(b'\n'):
                lines = data.decode('utf-8-sig').split('\n')
                blanks, above = (
                    len(text) - len(text.lstrip(' ')) for text in (lines[mark.line], lines[begun.line])
                )
                if lines[mark.line].strip() and blanks != above:
                    what += (
                        f'; this line has {blanks} blanks before it, and line {begun.line + 1} has {above}: '
                        'give it as many if it belongs to the same list'
                    )
            raise _make_error(
                Location(path, mark.line + 1 if mark else 1), f'no valid YAML: {what}'
            ) from error
        if not isinstance(node, yaml.MappingNode) or len(node.value) != 1:
            raise _make_error(Location(path, 1), "a launch file in YAML begins with 'launch:'")
        key, value = node.value[0]
        return _tag(path, str(key.value), value, key)


def _tag(path: str, name: str, node: yaml.Node, key: yaml.Node) -> Entity:
    location = Location(path, key.start_mark.line + 1)
    attributes: dict[str, Any] = {}
    children: list[Entity] = []
    if isinstance(node, yaml.SequenceNode):
        children = [_child(path, item) for item in node.value]
    elif isinstance(node, yaml.MappingNode):
        for inner_key, inner in node.value:
            inner_name = str(inner_key.value)
            if inner_name == 'children' and isinstance(inner, yaml.SequenceNode):
                children += [_child(path, item) for item in inner.value]
            elif _is_tags(inner):
                children += [_tag(path, inner_name, item, item) for item in inner.value]
            else:
                attributes[inner_name] = _value(path, inner)
    elif not (isinstance(node, yaml.ScalarNode) and node.value == ''):
        raise _make_error(location, f"'{name}' needs attributes or a list, not a single value")
    return Entity(name, attributes, children, location)


def _is_tags(node: yaml.Node) -> bool:
    return (
        isinstance(node, yaml.SequenceNode)
        and bool(node.value)
        and all(isinstance(item, yaml.MappingNode) for item in node.value)
    )


def _child(path: str, node: yaml.Node) -> Entity:
    if not isinstance(node, yaml.MappingNode) or len(node.value) != 1:
        raise _make_error(
            Location(path, node.start_mark.line + 1),
            'expected one tag with its attributes, such as `- node:`; are its attributes indented?',
        )
    key, value = node.value[0]
    return _tag(path, str(key.value), value, key)


def _value(path: str, node: yaml.Node) -> Any:
    try:
        loader = yaml.SafeLoader('')
        try:
            return loader.construct_document(node)
        finally:
            loader.dispose()
    except yaml.YAMLError as error:
        raise _make_error(Location(path, node.start_mark.line + 1), ' '.join(str(error).split())) from error


def _make_error(location: Location, text: str) -> InvalidFrontendLaunchFileError:
    return InvalidFrontendLaunchFileError(f'{location}: {text}', located=True)


def _absolute(name: str) -> str:
    return name if name.startswith('<') else str(Path(name).absolute())


def parse_texts(entity: Entity, parser: Parser, *names: str, **renamed: str) -> dict[str, Any]:
    """Return arguments for an action's constructor from its tag's attributes, which may contain $(…).

    `renamed` maps an argument to an attribute with another name: src='from'.
    """
    tagged = dict(zip(names, names, strict=True)) | renamed
    return {argument: parser.parse_substitution(entity.get_attr(name)) for argument, name in tagged.items()}
