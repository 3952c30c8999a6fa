"""jedi completes, and goes to, what messages have: it is in pylsp, vim, IPython and Jupyter."""

from __future__ import annotations

import os
import sys
import textwrap
from collections.abc import Callable, Iterator
from pathlib import Path

import jedi
import pytest
from helpers.fresh import output_of
from helpers.packages import write_package

from goalwire.idl import hook

LAMP = {
    'msg/Colour.msg': 'float32 red  # [0..1]\nfloat32 green\n',
    'srv/SetLight.srv': '# A light.\n\nfloat64 brightness 1.0  # 0: off\nColour colour\n---\nbool success\n',
}

Ask = Callable[[str], jedi.Script]


@pytest.fixture(scope='module')
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with lamp_interfaces."""
    folder = tmp_path_factory.mktemp('workspace')
    write_package(folder / 'src' / 'lamp_interfaces', 'lamp_interfaces', LAMP)
    return folder


@pytest.fixture(scope='module')
def editor(workspace: Path) -> Iterator[jedi.api.environment.Environment]:
    """The Python in which jedi looks for modules: a process of its own, as under an editor."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(workspace)
        patch.setenv('XDG_CACHE_HOME', str(workspace / 'cache'))
        yield jedi.create_environment(sys.prefix, safe=False)


@pytest.fixture
def ask(workspace: Path, editor: jedi.api.environment.Environment) -> Ask:
    """Open a program in the workspace."""
    project = jedi.Project(workspace)
    return lambda program: jedi.Script(textwrap.dedent(program), environment=editor, project=project)


def completions(script: jedi.Script) -> set[str]:
    """Return the names that an editor offers at the end of a program, except those that every object has."""
    return {found.name for found in script.complete() if not found.name.startswith('_')}


SHIPPED = 'from std_msgs.msg import Header\n'
OWN = 'from lamp_interfaces.srv import SetLight\n'


@pytest.mark.parametrize(
    ('program', 'offered'),
    {
        'kinds': ('import std_msgs.', {'msg'}),
        'kinds of an import': ('from sensor_msgs import ', {'msg', 'srv'}),
        'types': ('from std_msgs.msg import Str', {'String'}),
        'types of a module': ('import std_msgs.msg\nstd_msgs.msg.Hea', {'Header'}),
        'fields': (f'{SHIPPED}Header().', {'stamp', 'frame_id'}),
        'fields of fields': (f'{SHIPPED}Header().stamp.', {'sec', 'nanosec'}),
        'parts of a service': (
            'from std_srvs.srv import SetBool\nSetBool.',
            {'Request', 'Response', 'Event'},
        ),
        'elements': ('from nav_msgs.msg import Path\nPath().poses[0].pose.', {'position', 'orientation'}),
        'own types': ('from lamp_interfaces.srv import Set', {'SetLight'}),
        'own fields': (f'{OWN}SetLight.Request().', {'brightness', 'colour'}),
        'own fields of fields': (f'{OWN}SetLight.Request().colour.', {'red', 'green'}),
    }.values(),
    ids=lambda value: '',
)
def test_completion(ask: Ask, program: str, offered: set[str]) -> None:
    assert offered <= completions(ask(program))


def test_keywords_of_a_message_and_of_a_node_are_signatures(ask: Ask) -> None:
    (own,) = ask(f'{OWN}SetLight.Request(').get_signatures()
    assert [parameter.name for parameter in own.params] == ['brightness', 'colour', 'check_fields']
    (node,) = ask('import goalwire\ngoalwire.Node(').get_signatures()
    assert node.params[0].name == 'name'
    assert {'client', 'service', 'publisher'} <= completions(ask('import goalwire\ngoalwire.Node("n").'))


def test_a_definition_is_gone_to(ask: Ask) -> None:
    (shipped,) = ask(SHIPPED).goto(1, 27, follow_imports=True)
    assert Path(str(shipped.module_path)) == Path(hook.OVERLAY, 'std_msgs', 'msg', '__init__.pyi')
    (own,) = ask(OWN).goto(1, 36, follow_imports=True)
    assert own.description == 'class SetLight'


def test_comments_of_a_definition_are_its_documentation(ask: Ask) -> None:
    (request,) = ask(f'{OWN}SetLight.Request').infer()
    assert 'A light.' in request.docstring()


def test_a_changed_definition_is_seen(ask: Ask, workspace: Path) -> None:
    assert 'red' in completions(ask(f'{OWN}SetLight.Request().colour.'))
    file = workspace / 'src' / 'lamp_interfaces' / 'msg' / 'Colour.msg'
    file.write_text('float32 blue\n', encoding='utf-8')
    os.utime(file, (file.stat().st_atime, file.stat().st_mtime + 5))
    assert completions(ask(f'{OWN}SetLight.Request().colour.')) >= {'blue'}


def test_ipython_completes_what_a_cell_has_made(tmp_path: Path) -> None:
    program = """\
        import jedi
        from std_msgs.msg import Header
        header = Header()
        for text in ('header.', 'Header().stamp.', 'header.stamp.'):
            print([found.name for found in jedi.Interpreter(text, [globals()]).complete()][:3])
    """
    shown = output_of(program, cwd=tmp_path).splitlines()
    assert "'frame_id'" in shown[0]
    assert shown[1] == shown[2]
    assert "'nanosec'" in shown[1]


def test_programs_without_an_editor_write_no_stubs(tmp_path: Path) -> None:
    write_package(tmp_path / 'lamp_interfaces', 'lamp_interfaces', LAMP)
    output_of(f'{OWN}SetLight.Request()', cwd=tmp_path, XDG_CACHE_HOME=str(tmp_path / 'cache'))
    assert not (tmp_path / 'cache').exists()
