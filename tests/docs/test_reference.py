"""The reference pages name all that the code has, and nothing else."""

from __future__ import annotations

import ast
import inspect
import pickle
import re
from collections.abc import Iterator
from importlib import import_module
from pkgutil import walk_packages

import pytest
import tf2_ros
from helpers.markdown import DOCS, rows

import goalwire
from goalwire import errors
from goalwire.errors import GoalwireError, NotImplementedException, TransformException, TypeException
from goalwire.rules.arguments import parse_arguments
from tools.house import Module, modules

VARIABLE = re.compile(r'(AMENT|CYCLONEDDS|FASTDDS|FASTRTPS|GOALWIRE|RCUTILS|RMW|ROS2?|ZENOH)_[A-Z0-9_]+')
NO_VARIABLES = {'AMENT_IGNORE', 'AMENT_PREFIX_PATH_ENV_VAR', 'RCUTILS_LOG_SEVERITY'}
INTERNAL = {
    'InvalidName',
    'UnknownSubstitution',
    'RuleSyntaxError',
    'ArgumentError',
    'UnknownArguments',
    'ClosedByPeerError',
    'RtpsError',
    'ZenohProtocolError',
}
TF2 = (TransformException, TypeException, NotImplementedException)

ERRORS = {name: getattr(errors, name) for name in errors.__all__}
TREE = {name for name, value in ERRORS.items() if inspect.isclass(value) and issubclass(value, Exception)}


def _strings(module: Module) -> Iterator[str]:
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def test_every_environment_variable_of_the_code_is_on_its_page_and_no_other() -> None:
    in_code = {text for module in modules() for text in _strings(module) if VARIABLE.fullmatch(text)}
    in_code -= NO_VARIABLES
    page = DOCS / 'reference' / 'environment-variables.md'
    in_rows = re.findall(r'^\| `([A-Z0-9_]+)` \|', page.read_text(encoding='utf-8'), re.MULTILINE)
    assert sorted(in_rows) == sorted(in_code)


def _descendants(error: type[GoalwireError]) -> Iterator[type[GoalwireError]]:
    yield error
    for derived in error.__subclasses__():
        yield from _descendants(derived)


def test_the_table_of_errors_is_the_tree_of_the_code() -> None:
    for module in walk_packages(goalwire.__path__, 'goalwire.'):
        if not module.name.startswith(('goalwire.overlay', 'goalwire.packaging', 'goalwire.run')):
            import_module(module.name)
    in_code = {
        error.__name__: ', '.join(f'`{base.__name__}`' for base in error.__bases__)
        for error in _descendants(GoalwireError)
        if error.__module__.split('.')[0] == 'goalwire'
        and not issubclass(error, TF2)  # one sentence on the page
        and error.__name__ not in INTERNAL
    }
    table = rows(DOCS / 'reference' / 'errors.md', 'error')
    on_page = {name.strip('`'): bases for name, bases, _ in table if name.startswith('`')}
    assert on_page == in_code


def test_every_public_error_is_defined_in_one_folder() -> None:
    elsewhere = {
        f'{module.name}: {node.name}'
        for module in modules()
        for node in ast.walk(module.tree)
        if isinstance(node, ast.ClassDef)
        and node.name not in INTERNAL
        and module.path.parent.name != 'errors'
        if {base.id for base in node.bases if isinstance(base, ast.Name)} & set(TREE)
    }
    assert not elsewhere


def test_every_error_says_where_programs_import_it_from() -> None:
    named = {error.__module__ for name, error in ERRORS.items() if name in TREE}
    assert named == {'goalwire.errors', 'tf2_py'}
    assert set(dir(errors)) >= TREE
    assert pickle.loads(pickle.dumps(errors.MissionFailed('late'))).args == ('late',)


def test_an_unknown_error_is_a_missing_attribute() -> None:
    with pytest.raises(AttributeError, match=r"'goalwire\.errors' has no attribute 'NoSuchError'"):
        getattr(errors, 'NoSuchError')  # noqa: B009 - a type checker refuses the plain form


def test_tf2s_timeout_keeps_its_name_and_can_be_sent_to_another_process() -> None:
    error = pickle.loads(pickle.dumps(tf2_ros.TimeoutException('late')))
    assert type(error) is tf2_ros.TimeoutException
    assert type(error).__name__ == 'TimeoutException'
    assert str(error) == 'late'


def test_every_ros_argument_of_the_page_is_understood() -> None:
    page = DOCS / 'reference' / 'arguments-of-programs.md'
    arguments = [text for cells in rows(page, 'argument') for text in re.findall(r'`([^`]+)`', cells[0])]
    values = {'FROM:=TO': 'a:=b', 'FILE': 'x.yaml', 'PREFIX': 'x', 'PATH': '/x', 'LEVEL': 'INFO'}
    assert len(arguments) > 15
    for argument in arguments:
        words = argument.replace('LOGGER:=LEVEL', 'x:=INFO').replace('/NAMESPACE', '/x').split()
        parse_arguments(['--ros-args', *(values.get(word, word) for word in words)])


def test_every_ros_argument_of_the_code_is_on_the_page() -> None:
    text = (DOCS / 'reference' / 'arguments-of-programs.md').read_text(encoding='utf-8')
    strings = {text for module in modules() if module.name == 'rules.arguments' for text in _strings(module)}
    valued = {flag for flag in strings if re.fullmatch(r'--?[a-z][a-z-]*', flag)} - {'--ros-args'}
    assert len(valued) > 8
    for flag in valued | {f'--{verb}-stdout-logs' for verb in ('enable', 'disable')}:
        assert f'`{flag}' in text, flag
