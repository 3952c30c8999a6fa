"""Reads launch files in Python, XML and YAML, and includes them in each other."""

from __future__ import annotations

import contextlib
import importlib.machinery
import importlib.util
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from types import ModuleType
from typing import Any, TypeAlias

from goalwire.errors import (
    InvalidFrontendLaunchFileError,
    InvalidLaunchFileError,
    LaunchError,
    NoLaunchFileError,
    NoSuchPackageError,
)
from goalwire.files import read_regular, show
from goalwire.launching.actions import (
    DeclareLaunchArgument,
    OpaqueFunction,
)
from goalwire.launching.errors import Location, locate, remember_launch_file
from goalwire.launching.exposure import expose_action
from goalwire.launching.frontend import Entity, Parser, XMLParser, YAMLParser
from goalwire.launching.model import (
    Action,
    ArgumentSearch,
    FoundArgument,
    LaunchContext,
    LaunchDescription,
    LaunchDescriptionEntity,
    SomeSubstitutions,
    Substitution,
)
from goalwire.launching.scopes import (
    PopEnvironment,
    PopLaunchConfigurations,
    PushEnvironment,
    PushLaunchConfigurations,
    SetLaunchConfiguration,
)
from goalwire.launching.source_modules import offer_source_modules
from goalwire.launching.substitutions import LaunchConfiguration
from goalwire.launching.values import (
    describe_text,
    normalize_to_list_of_substitutions,
    perform_substitutions,
    perform_text,
)

LARGEST = 2**24
"""The largest size of a launch file, in bytes."""
DEEPEST = 20
"""The deepest nesting of includes that is followed without a launch."""
PYTHON_ENDINGS = ('.py',)
Loader: TypeAlias = Callable[[str], LaunchDescription]


def load_python_launch_file_as_module(launch_file_path: str) -> ModuleType:
    """Run a Python launch file and return it as a module. Raises LaunchError, with file and line."""
    path = os.path.abspath(launch_file_path)
    loader = importlib.machinery.SourceFileLoader('python_launch_file', path)
    spec = importlib.util.spec_from_loader(loader.name, loader)
    if spec is None:
        raise InvalidLaunchFileError(f'{show(path)} cannot be loaded as Python')
    module = importlib.util.module_from_spec(spec)
    remember_launch_file(path)
    _readable(path)
    offer_source_modules()
    before, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # writes no __pycache__
    try:
        loader.exec_module(module)
    except Exception as error:
        raise locate(error, None) from error
    finally:
        sys.dont_write_bytecode = before
    return module


def get_launch_description_from_python_launch_file(launch_file_path: str) -> LaunchDescription:
    """Return the description that generate_launch_description() of a Python launch file returns."""
    module = load_python_launch_file_as_module(launch_file_path)
    function = getattr(module, 'generate_launch_description', None)
    if not callable(function):
        raise InvalidLaunchFileError(
            f'{show(launch_file_path)} does not define generate_launch_description(): '
            'write a function of that name, which returns a LaunchDescription'
        )
    try:
        description = function()
    except Exception as error:
        raise locate(error, None) from error
    if not isinstance(description, LaunchDescription):
        raise InvalidLaunchFileError(
            f'{show(launch_file_path)}: generate_launch_description() returned '
            f"{type(description).__name__}, not a LaunchDescription: write 'return LaunchDescription([…])'"
        )
    return description


def get_launch_description_from_frontend_launch_file(
    launch_file_path: str, *, parser: type[Parser] | None = None
) -> LaunchDescription:
    """Return the description in an XML or YAML file; the file's ending tells the format."""
    _readable(launch_file_path)
    chosen = parser or Parser
    root, chosen_parser = chosen.load(launch_file_path)
    description: LaunchDescription = chosen_parser.parse_description(root)
    return description


def get_launch_description_from_any_launch_file(
    launch_file_path: str, *, parser: type[Parser] | None = None
) -> LaunchDescription:
    """Return the description in a launch file of any kind. Raises LaunchError, with file and line."""
    if launch_file_path.endswith(PYTHON_ENDINGS):
        return get_launch_description_from_python_launch_file(launch_file_path)
    if parser is None and not Parser.is_filename_valid(launch_file_path):
        return _description_by_content(launch_file_path)
    return get_launch_description_from_frontend_launch_file(launch_file_path, parser=parser)


def _description_by_content(path: str) -> LaunchDescription:
    """Read a file whose ending does not tell the format, such as `.launch`: try XML, then YAML, then Python.

    Raises InvalidLaunchFileError with the reasons of all three, or only of XML if the file begins with a tag.
    """
    _readable(path)
    content = read_regular(path, LARGEST)
    failures: list[Exception] = []
    for notation, parser in (('XML', XMLParser), ('YAML', YAMLParser)):
        try:
            parser.read(content, path)
        except InvalidFrontendLaunchFileError as error:
            if notation == 'XML' and content.lstrip().startswith(b'<'):
                raise
            failures.append(error)
            continue
        return get_launch_description_from_frontend_launch_file(path, parser=parser)
    if b'def generate_launch_description' in content:
        return get_launch_description_from_python_launch_file(path)
    reasons = '; '.join(
        f'as {notation}: {error}' for notation, error in zip(('XML', 'YAML'), failures, strict=True)
    )
    raise InvalidLaunchFileError(
        f'{show(path)} is not a launch file: {reasons}; '
        'as Python: it defines no generate_launch_description()'
    )


def _readable(path: str) -> None:
    try:
        read_regular(path, LARGEST)
    except OSError as error:
        kind = NoLaunchFileError if isinstance(error, FileNotFoundError) else InvalidLaunchFileError
        raise kind(f'cannot read the launch file {show(path)}: {error.strerror}') from error


class LaunchDescriptionSource:
    """The source of an included launch description, which is read when the include is carried out."""

    def __init__(
        self,
        launch_description: LaunchDescription | None = None,
        location: SomeSubstitutions = '',
        method: str = 'unspecified mechanism from a script',
    ) -> None:
        self._description = launch_description
        self._location = normalize_to_list_of_substitutions(location)
        self._expanded: str | None = None
        self._missing: str | None = None
        self._method = method

    @property
    def location(self) -> str:
        """The path of the launch file, once evaluated; before that, a text that shows it unevaluated."""
        return self._expanded or describe_text(self._location)

    @property
    def method(self) -> str:
        return self._method

    def _get_launch_description(self, location: str) -> LaunchDescription:
        raise LaunchError(
            f'{type(self).__name__} was made without a launch description, and cannot read a file: '
            'give it a description, or use AnyLaunchDescriptionSource(path)'
        )

    def get_launch_description(self, context: LaunchContext) -> LaunchDescription:
        """Read the launch file once, and return its description."""
        if self._description is None:
            self._expanded = perform_substitutions(context, self._location)
            self._description = self._get_launch_description(self._expanded)
        elif self._expanded is None and self._location:
            self._expanded = perform_substitutions(context, self._location)
        return self._description

    def try_get_launch_description_without_context(
        self, including: Location | None = None
    ) -> LaunchDescription | None:
        """Read the file and return its description; return None if its path is known only in a launch.

        `including` is the line of the include: $(dirname) stands for the folder of the file with that line.
        """
        context = LaunchContext()
        if including is not None:
            context.extend_globals(_this_file(including.file))
        try:
            return self.get_launch_description(context)
        except Exception as error:
            if isinstance(error, NoLaunchFileError | NoSuchPackageError):
                self._missing = str(error)
            elif isinstance(error, InvalidLaunchFileError) or (
                isinstance(error, LaunchError) and error.located
            ):
                raise
            self._expanded = None
            return None

    @property
    def missing(self) -> str | None:
        """The reason why reading without a context did not find the file; None if it was found."""
        return self._missing


class PythonLaunchDescriptionSource(LaunchDescriptionSource):
    """A Python launch file."""

    def __init__(self, launch_file_path: SomeSubstitutions) -> None:
        super().__init__(None, launch_file_path, 'interpreted python launch file')

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_python_launch_file(location)


class FrontendLaunchDescriptionSource(LaunchDescriptionSource):
    """An XML or YAML launch file."""

    def __init__(self, launch_file_path: SomeSubstitutions, *, parser: type[Parser] | None = None) -> None:
        super().__init__(None, launch_file_path, 'interpreted frontend launch file')
        self._parser = parser

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_frontend_launch_file(location, parser=self._parser)


class XMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """An XML launch file."""

    def __init__(self, launch_file_path: SomeSubstitutions) -> None:
        super().__init__(launch_file_path, parser=XMLParser)


class YAMLLaunchDescriptionSource(FrontendLaunchDescriptionSource):
    """A YAML launch file."""

    def __init__(self, launch_file_path: SomeSubstitutions) -> None:
        super().__init__(launch_file_path, parser=YAMLParser)


class AnyLaunchDescriptionSource(LaunchDescriptionSource):
    """A launch file of any kind."""

    def __init__(self, launch_file_path: SomeSubstitutions) -> None:
        super().__init__(None, launch_file_path, 'interpreted launch file')

    def _get_launch_description(self, location: str) -> LaunchDescription:
        return get_launch_description_from_any_launch_file(location)


Arguments: TypeAlias = Iterable[tuple[SomeSubstitutions, SomeSubstitutions]]


@expose_action('include')
class IncludeLaunchDescription(Action):
    """Carries out another launch file. As in launch, both files share their launch configurations."""

    def __init__(
        self,
        launch_description_source: LaunchDescriptionSource | SomeSubstitutions,
        *,
        launch_arguments: Arguments | None = None,
        **options: Any,
    ) -> None:
        super().__init__(**options)
        if not isinstance(launch_description_source, LaunchDescriptionSource):
            launch_description_source = AnyLaunchDescriptionSource(launch_description_source)
        self._source = launch_description_source
        self._arguments = [(name, value) for name, value in launch_arguments or ()]

    @classmethod
    def parse(cls, entity: Entity, parser: Parser) -> tuple[type[Action], dict[str, Any]]:
        _, arguments = super().parse(entity, parser)
        arguments['launch_description_source'] = parser.parse_substitution(entity.get_attr('file'))
        given = [*entity.get_entities('arg'), *entity.get_entities('let')]
        arguments['launch_arguments'] = [
            (
                parser.parse_substitution(item.get_attr('name')),
                parser.parse_substitution(item.get_attr('value')),
            )
            for item in given
        ]
        for item in given:
            item.assert_entity_completely_parsed()
        return cls, arguments

    @property
    def launch_description_source(self) -> LaunchDescriptionSource:
        return self._source

    @property
    def launch_arguments(self) -> Sequence[tuple[SomeSubstitutions, SomeSubstitutions]]:
        return tuple(self._arguments)

    def describe(self) -> str:
        return f'IncludeLaunchDescription({self._source.location})'

    def read_ahead(self) -> LaunchDescription | None:
        """Return the description if it can be read without a launch, else None."""
        return self._source.try_get_launch_description_without_context(self.location)

    def list_decided_names(self) -> set[str]:
        """Return the names of the arguments that the include sets.

        Arguments that the include passes on, as in `<arg name="a" value="$(var a)"/>`, are left out: the
        command line sets these.
        """
        names = set()
        for name, value in self._arguments:
            with contextlib.suppress(Exception):
                plain = perform_text(LaunchContext(), name)
                if plain not in _configurations_in(value):
                    names.add(plain)
        return names

    def find_arguments(self, search: ArgumentSearch) -> Iterator[FoundArgument]:
        inner = self.read_ahead()
        if inner is None or len(search.includes) >= DEEPEST:
            return
        inside = ArgumentSearch(
            includes=(*search.includes, self),
            decided=search.decided | self.list_decided_names(),
            is_conditional=search.is_conditional or self.condition is not None,
        )
        for entity in inner.entities:
            yield from entity.find_arguments(inside)

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        description = self._source.get_launch_description(context)
        path = self._source.location
        globals_ = context.get_globals()
        names = _this_file(path).keys()
        context.extend_globals(_this_file(path))

        def go_back(context: LaunchContext) -> None:
            context.remove_globals(names)
            context.extend_globals({name: globals_[name] for name in names if name in globals_})

        given = [
            (perform_text(context, name), normalize_to_list_of_substitutions(value))
            for name, value in self._arguments
        ]
        if self.location is not None:  # an error of the outermost file names the argument's line by itself
            self._check_required(context, description, {name for name, _ in given})
        sets: list[LaunchDescriptionEntity] = []
        for name, value in given:
            action = SetLaunchConfiguration(name, _outside(value, globals_))
            action.location = self.location
            sets.append(action)
        # The outermost file's global names stay set, since its event handlers may use $(dirname) later.
        back = [OpaqueFunction(function=go_back)] if names & globals_.keys() else []
        return [*sets, description, *back]

    def _check_required(
        self, context: LaunchContext, description: LaunchDescription, given: set[str]
    ) -> None:
        for entity in description.entities:
            if (
                isinstance(entity, DeclareLaunchArgument)
                and entity.condition is None
                and entity.default_value is None
                and entity.name not in given
                and entity.name not in context.launch_configurations
            ):
                raise LaunchError(
                    f"included launch file {self._source.location} needs the argument '{entity.name}', "
                    'which is not given'
                )


def _configurations_in(value: SomeSubstitutions) -> set[str]:
    """Return the launch configurations that a text refers to by plain names."""
    names = set()
    for part in normalize_to_list_of_substitutions(value):
        if isinstance(part, LaunchConfiguration):
            with contextlib.suppress(Exception):
                names.add(perform_substitutions(LaunchContext(), part.variable_name))
    return names


def _this_file(path: str) -> dict[str, str]:
    """Return the global names, with values, for the path and the folder of a launch file."""
    full = os.path.abspath(path)
    return {'current_launch_file_path': full, 'current_launch_file_directory': os.path.dirname(full)}


class _Outside(Substitution):
    """The value of an include's argument: $(dirname) in it stands for the folder of the including file."""

    def __init__(self, inner: list[Substitution], globals_: dict[str, Any]) -> None:
        self._inner = inner
        self._globals = globals_

    def describe(self) -> str:
        return describe_text(self._inner)

    def perform(self, context: LaunchContext) -> str:
        inside = context.get_globals()
        context.remove_globals(inside)
        context.extend_globals(self._globals)
        try:
            return perform_substitutions(context, self._inner)
        finally:
            context.remove_globals(context.get_globals())
            context.extend_globals(inside)


def _outside(value: list[Substitution], globals_: dict[str, Any]) -> _Outside:
    return _Outside(value, globals_)


class ScopedIncludeLaunchDescription(IncludeLaunchDescription):
    """Includes a launch file; its changes of launch configurations and environment end with the file."""

    def execute(self, context: LaunchContext) -> list[LaunchDescriptionEntity]:
        return [
            PushLaunchConfigurations(),
            PushEnvironment(),
            *super().execute(context),
            PopEnvironment(),
            PopLaunchConfigurations(),
        ]
