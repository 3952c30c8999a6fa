"""$(…) in XML and YAML, and what texts are worth."""

from __future__ import annotations

from typing import Any

import pytest
from launch import LaunchContext
from launch.frontend import parse_substitution
from launch.substitutions import (
    AnonName,
    Command,
    EqualsSubstitution,
    IfElseSubstitution,
    NotEqualsSubstitution,
    PathJoinSubstitution,
    PathSubstitution,
    PythonExpression,
    StringJoinSubstitution,
)
from launch.utilities import perform_substitutions

from goalwire.errors import BadLaunchValueError, LaunchError, SubstitutionFailure
from goalwire.launching.expressions import evaluate
from goalwire.launching.ros.namespaces import join_namespace
from goalwire.launching.ros.parameters import as_rule, by_yaml, evaluate_dictionary


@pytest.fixture
def context() -> LaunchContext:
    context = LaunchContext()
    context.launch_configurations |= {'a': 'x', 'flag': 'true', 'two words': 'w', 'number': '3'}
    return context


TEXTS = {
    '': '',
    'plain': 'plain',
    "it's": "it's",
    '$(var a)': 'x',
    'pre$(var a)post $(var a)': 'prexpost x',
    r'\$(var a) \\ \"': '$(var a) \\ "',
    '$(var $(if true a b))': 'x',
    "$(var 'two words')": 'w',
    '$(var missing "a default")': 'a default',
    '$(var missing $(var a)y)': 'xy',
    '$(var   a )': 'x',
    "$(eval '$(var number) * 2 + 1')": '7',
    "$(eval \"'$(var a)' == 'x' and not False\")": 'True',
    "$(eval 'sqrt(16)')": '4.0',
    "$(eval 'datetime.date(2020, 1, 2).isoformat()' 'datetime')": '2020-01-02',
    '$(and $(var flag) false)': 'false',
    '$(or $(var flag) false)': 'true',
    '$(any false false 1)': 'true',
    '$(all true false)': 'false',
    '$(not-equals a b)': 'true',
    '$(equals 1 1.0)': 'true',
    '$(equals True 1)': 'true',
    '$(equals on true)': 'false',  # as in ROS 2: only true, false, 1 and 0 stand for each other
    '$(if $(var flag) yes no)': 'yes',
    '$(env NOT_THERE_AT_ALL fallback)': 'fallback',
    "$(command 'echo hello')": 'hello\n',
    '$(string-join . a b $(var a))': 'a.b.x',
    '$ (a) $': '$ (a) $',
}


@pytest.mark.parametrize('text', list(TEXTS))
def test_texts_with_substitutions(text: str, context: LaunchContext) -> None:
    assert perform_substitutions(context, parse_substitution(text)) == TEXTS[text]


@pytest.mark.parametrize('text', ['$(', '$(var', '$(var "a)', '$(1 a)', "$(var'a')", '$(not)', '$(equals a)'])
def test_texts_that_cannot_be_read(text: str) -> None:
    with pytest.raises((LaunchError, TypeError)):
        parse_substitution(text)


@pytest.mark.parametrize(
    'expression',
    [
        '__import__("os")',
        'open("x")',
        'eval("1")',
        '().__class__',
        'lambda: 1',
        '[x for x in (y := [1])]',
        'exec("")',
    ],
)
def test_expressions_are_restricted(expression: str) -> None:
    with pytest.raises(SubstitutionFailure):
        evaluate(expression)


def test_expressions_know_the_modules_that_they_are_given() -> None:
    assert evaluate('os.path.basename("/a/b")', ['os']) == 'b'
    assert evaluate('math.pi > 3 and pi > 3') == 'True'
    with pytest.raises(SubstitutionFailure, match="name 'os' is not defined"):
        evaluate('os.getcwd()')


def test_substitutions_in_python(context: LaunchContext) -> None:
    assert PathJoinSubstitution(['a', ['b', 'c'], 'd']).perform(context) == 'a/bc/d'
    assert (PathSubstitution('a') / 'b' / 'c').perform(context) == 'a/b/c'
    assert EqualsSubstitution('True', 'true').perform(context) == 'true'
    assert NotEqualsSubstitution(None, '').perform(context) == 'false'
    assert IfElseSubstitution('false', 'a', 'b').perform(context) == 'b'
    assert IfElseSubstitution('false', 'a').perform(context) == ''
    with pytest.raises(BadLaunchValueError, match='needs if_value or else_value: both are missing'):
        IfElseSubstitution('true')
    assert StringJoinSubstitution([['a', 'b'], 'c'], delimiter='-').perform(context) == 'ab-c'
    assert PythonExpression(['1', '+', '1']).perform(context) == '2'
    assert AnonName('x').perform(context) == AnonName('x').perform(context) != AnonName('y').perform(context)


def test_a_command_that_complains(context: LaunchContext) -> None:
    said = 'sh -c "echo out; echo err >&2"'
    with pytest.raises(SubstitutionFailure, match='printed to its standard error: err'):
        Command(said).perform(context)
    assert Command(said, on_stderr='ignore').perform(context) == 'out\n'
    assert Command(said, on_stderr='capture').perform(context) == 'out\nerr\n'
    with pytest.raises(SubstitutionFailure, match='cannot run the command'):
        Command('no_such_program_at_all').perform(context)


PARAMETERS: dict[str, tuple[Any, Any]] = {
    'string': ('5', '5'),
    'number': (5, 5),
    'boolean': (True, True),
    'ints': ([1, 2], (1, 2)),
    'mixed numbers': ([1, 2.5], (1.0, 2.5)),
    'strings': (['a', '1'], ('a', '1')),
    'nothing': ([], ()),
    'substitution': (parse_substitution('$(var number)')[0], 3),
    'several': (parse_substitution('$(var a)$(var number)'), 'x3'),
    'list text': (parse_substitution('[1, $(var number)]'), (1, 3)),
}


@pytest.mark.parametrize('name', list(PARAMETERS))
def test_parameters(name: str, context: LaunchContext) -> None:
    value, wanted = PARAMETERS[name]
    assert evaluate_dictionary(context, {'a': {'b': value}}) == {'a.b': wanted}


def test_parameters_that_no_node_can_have(context: LaunchContext) -> None:
    for value in ([1, 'a'], [True, 1], None, object()):
        with pytest.raises(LaunchError, match="parameter 'a'"):
            evaluate_dictionary(context, {'a': value})


NAMESPACES = {
    (None, None): None,
    (None, ''): '/',
    (None, 'a'): '/a',
    (None, '/a/'): '/a',
    ('/r', None): '/r',
    ('/r', ''): '/r',
    ('/r', 'a'): '/r/a',
    ('/r', '/a'): '/a',
    ('/', 'a'): '/a',
}


@pytest.mark.parametrize(('base', 'own'), list(NAMESPACES))
def test_namespaces_below_each_other(base: str | None, own: str | None) -> None:
    assert join_namespace(base, own) == NAMESPACES[base, own]


def test_rules_for_the_command_line() -> None:
    assert as_rule('a', True) == 'a:=true'
    assert as_rule('a', [1, 2]) == 'a:=[1, 2]'
    assert as_rule('a', '5') == "a:='5'"
    assert as_rule('a', 'x') == 'a:=x'


@pytest.mark.parametrize('text', ['{a: 1}', '[]', '[1, a]', '[[1], [2]]'])
def test_a_text_that_stands_for_no_parameter_is_refused(text: str) -> None:
    with pytest.raises(BadLaunchValueError, match=r'Expected a non-empty sequence|Allowed value types'):
        by_yaml(text)
