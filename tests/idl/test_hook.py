from __future__ import annotations

import importlib
import importlib.util
import pickle
import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from helpers.fresh import output_of, run_python
from helpers.packages import write_files, write_package

from goalwire.errors import InterfaceSyntaxError
from goalwire.idl import hook, register_definitions, search_path

ARM = {
    'msg/Joint.msg': 'string name\nfloat64 angle # [rad]\n',
    'srv/Move.srv': 'Joint to\n---\nbool done\n',
    'action/Wave.action': 'int32 times\n---\nbool done\n---\nint32 so_far\n',
}
BESIDE_A_REAL_RCLPY = """\
    import sys
    sys.path.insert(0, 'real')
    try:
        import std_msgs.msg
    except ModuleNotFoundError as error:
        print(error)
    import rclpy
    print(rclpy.WHO)
"""


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty working directory; modules imported from it are forgotten afterwards."""
    before = set(sys.modules)
    monkeypatch.chdir(tmp_path)
    importlib.invalidate_caches()
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.partition('.')[0].startswith('try_'):
            del sys.modules[name]
    importlib.invalidate_caches()


def test_an_interface_may_be_a_programs_first_line(tmp_path: Path) -> None:
    write_package(tmp_path / 'src' / 'arm', 'arm_interfaces', ARM)
    shown = output_of('from arm_interfaces.srv import Move; print(Move.Request())', cwd=tmp_path)
    joint = "arm_interfaces.msg.Joint(name='', angle=0.0)"
    assert shown == f'arm_interfaces.srv.Move_Request(to={joint})'


def test_each_package_is_looked_for_once(tmp_path: Path) -> None:
    program = """\
        from collections import Counter
        from goalwire.idl import search_path
        asked, find = Counter(), search_path.find_package
        search_path.find_package = lambda name, **how: asked.update([name]) or find(name, **how)
        from control_msgs.action import FollowJointTrajectory
        from geometry_msgs.msg import PoseStamped
        FollowJointTrajectory.Goal(), FollowJointTrajectory.Impl.SendGoalService.Request(), PoseStamped()
        print(*sorted(asked.items()))
    """
    used = ('builtin_interfaces', 'control_msgs', 'geometry_msgs', 'std_msgs', 'trajectory_msgs')
    once = ' '.join(str((name, 1)) for name in (*used, 'unique_identifier_msgs'))
    assert output_of(program, cwd=tmp_path) == once


def test_an_imported_package_stays_where_it_was_found(tmp_path: Path) -> None:
    write_package(tmp_path / 'one' / 'arm', 'arm_interfaces', ARM)
    write_package(tmp_path / 'two' / 'arm_interfaces', 'arm_interfaces', {'msg/Other.msg': 'bool b\n'})
    program = """\
        import os
        import arm_interfaces.msg as msg
        os.environ['GOALWIRE_INTERFACE_PATH'] = '../two'
        print(msg.Joint().name == '', hasattr(msg, 'Other'))
    """
    assert output_of(program, cwd=tmp_path / 'one') == 'True False'


def test_packages_may_be_imported_in_any_order_and_in_every_form(tmp_path: Path) -> None:
    write_package(tmp_path / 'arm', 'arm_interfaces', ARM)
    program = """\
        import arm_interfaces.action
        import geometry_msgs.msg as geometry
        from arm_interfaces import msg, srv
        from arm_interfaces.msg import *
        from arm_interfaces.srv._move import Move, Move_Request, Metaclass_Move
        import arm_interfaces.action._wave as wave
        assert arm_interfaces.msg.Joint is Joint is msg.Joint is msg._joint.Joint
        assert srv.Move is Move and Move.Request is Move_Request and type(Move) is Metaclass_Move
        assert arm_interfaces.action.Wave.Impl.SendGoalService.Request is wave.Wave_SendGoal_Request
        assert wave.Wave_FeedbackMessage is wave.Wave.Impl.FeedbackMessage
        assert geometry.Pose().orientation.w == 1.0
        print('all')
    """
    assert output_of(program, cwd=tmp_path) == 'all'


def test_a_folder_of_the_packages_name_does_not_hide_it(tmp_path: Path) -> None:
    write_package(tmp_path / 'arm_interfaces', 'arm_interfaces', ARM)
    shown = output_of('from arm_interfaces.msg import Joint; print(Joint.__module__)', cwd=tmp_path)
    assert shown == 'arm_interfaces.msg._joint'


def test_a_regular_package_always_wins(tmp_path: Path) -> None:
    write_files(tmp_path, {'std_msgs/__init__.py': '', 'std_msgs/msg.py': 'String = "theirs"'})
    assert output_of('from std_msgs.msg import String; print(String)', cwd=tmp_path) == 'theirs'


def test_a_module_of_a_finder_behind_the_path_finder_wins_too(tmp_path: Path) -> None:
    program = """\
        import sys
        from importlib.machinery import ModuleSpec, SourceFileLoader
        class Editable:
            def find_spec(self, name, path=None, target=None):
                if name == 'std_msgs':
                    return ModuleSpec(name, SourceFileLoader(name, 'theirs.py'), origin='theirs.py')
        sys.meta_path.append(Editable())
        import std_msgs
        print(std_msgs.WHO)
    """
    write_files(tmp_path, {'theirs.py': 'WHO = "an editable install"'})
    assert output_of(program, cwd=tmp_path) == 'an editable install'


def test_a_folder_that_is_no_interface_package_stays_a_namespace_package(tmp_path: Path) -> None:
    write_files(tmp_path, {'plain/inner.py': 'x = 1'})
    assert output_of('import plain.inner; print(plain.inner.x)', cwd=tmp_path) == '1'


def test_beside_a_real_rclpy_nothing_is_served(tmp_path: Path) -> None:
    write_files(tmp_path, {'real/rclpy/__init__.py': 'WHO = "real"'})
    assert output_of(BESIDE_A_REAL_RCLPY, cwd=tmp_path).splitlines() == [
        "No module named 'std_msgs'",
        'real',
    ]


def test_a_folder_named_rclpy_is_no_real_rclpy(tmp_path: Path) -> None:
    (tmp_path / 'rclpy').mkdir()
    assert output_of('import std_msgs.msg; print("served")', cwd=tmp_path) == 'served'


def test_a_rclpy_elsewhere_wins_even_where_the_overlay_comes_first_in_the_path(tmp_path: Path) -> None:
    write_files(tmp_path, {'real/rclpy/__init__.py': 'WHO = "real"'})
    program = """\
        import sys
        from goalwire.idl.hook import OVERLAY
        sys.path.insert(0, OVERLAY)
        sys.path.append('real')
        import rclpy
        print(rclpy.WHO)
    """
    assert output_of(program, cwd=tmp_path) == 'real'


def test_the_overlay_can_be_put_first(tmp_path: Path) -> None:
    write_files(tmp_path, {'real/rclpy/__init__.py': 'WHO = "real"'})
    program = """\
        import importlib.util, sys
        sys.path.insert(0, 'real')
        print(importlib.util.find_spec('rclpy').origin)
        import std_msgs.msg
    """
    assert output_of(program, cwd=tmp_path, GOALWIRE_FIRST='1').startswith(hook.OVERLAY)


def test_an_unknown_type_is_refused_with_its_folder_and_close_names() -> None:
    with pytest.raises(ImportError, match=r"cannot import name 'Strng' from std_msgs\.msg") as caught:
        from std_msgs.msg import Strng  # type: ignore[attr-defined]  # noqa: F401
    assert str(Path(search_path.SHIPPED) / 'std_msgs') in str(caught.value)
    assert 'did you mean String?' in str(caught.value)


def test_a_missing_kind_is_refused_with_the_packages_folder() -> None:
    with pytest.raises(ModuleNotFoundError, match=r'std_msgs has no srv types \(its definitions are in '):
        importlib.import_module('std_msgs.srv')


def test_a_missing_package_that_looks_like_one_is_explained(here: Path) -> None:
    with pytest.raises(ModuleNotFoundError, match="No module named 'try_interfaces', and") as caught:
        import try_interfaces  # type: ignore[import-not-found]  # noqa: F401
    assert str(here) in str(caught.value)
    assert search_path.INTERFACE_PATH in str(caught.value)


@pytest.mark.parametrize('name', ['try_interfaces', 'std_msgs.msg.Strng', 'std_msgs.srv', 'std_msgs.nothing'])
def test_asking_whether_a_module_exists_raises_nothing(name: str, here: Path) -> None:
    importlib.import_module('std_msgs.msg')
    assert importlib.util.find_spec(name) is None


def test_any_other_missing_module_is_python_s_business(here: Path) -> None:
    with pytest.raises(ModuleNotFoundError) as caught:
        importlib.import_module('try_nothing')
    assert str(caught.value) == "No module named 'try_nothing'"


def test_a_malformed_file_fails_where_its_type_is_imported_and_nowhere_else(here: Path) -> None:
    files = {'msg/Good.msg': 'int32 x', 'msg/Bad.msg': '# a comment\nint33 x\n'}
    package = write_package(here / 'p', 'try_msgs', files)
    good = importlib.import_module('try_msgs.msg')
    assert good.Good().x == 0
    with pytest.raises(ImportError) as caught:
        exec('from try_msgs.msg import Bad')
    assert isinstance(caught.value, InterfaceSyntaxError)
    assert f'{package / "msg" / "Bad.msg"}:2' in str(caught.value)


def test_types_registered_as_text_are_served(here: Path) -> None:
    register_definitions('try_text_msgs', {'msg/Pair': 'int32 a\nint32 b', 'srv/Ask': '---\nPair answer'})
    msg = importlib.import_module('try_text_msgs.msg')
    srv = importlib.import_module('try_text_msgs.srv')
    assert msg.__all__ == ['Pair']
    assert isinstance(srv.Ask.Response().answer, msg.Pair)


def test_modules_are_found_while_another_thread_is_importing_the_registry(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    name = 'goalwire.idl.registry'
    monkeypatch.setitem(sys.modules, name, ModuleType(name))  # as it is at its import's beginning
    assert importlib.util.find_spec('try_no_such_msgs') is None


def test_classes_are_pickled_by_their_module() -> None:
    from geometry_msgs.msg import Point

    assert pickle.loads(pickle.dumps(Point(x=1.5))) == Point(x=1.5)


def test_a_pickle_is_read_in_a_fresh_interpreter(tmp_path: Path) -> None:
    from std_srvs.srv import SetBool

    data = pickle.dumps(SetBool.Request(data=True)).hex()
    program = 'import pickle, sys; print(pickle.loads(bytes.fromhex(sys.argv[1])).data)'
    assert output_of(program, data, cwd=tmp_path) == 'True'


def test_a_module_lists_its_types() -> None:
    import std_srvs.srv

    assert std_srvs.srv.__all__ == ['Empty', 'SetBool', 'Trigger']
    assert {'Empty', 'SetBool', 'Trigger', '_set_bool'} <= set(dir(std_srvs.srv))
    assert {'SetBool', 'SetBool_Request', 'Metaclass_SetBool_Event'} <= set(
        dir(importlib.import_module('std_srvs.srv._set_bool'))
    )


def test_derived_types_are_names_of_the_kind_s_module_too(capsys: pytest.CaptureFixture[str]) -> None:
    program = """\
        from example_interfaces.action import Fibonacci, Fibonacci_FeedbackMessage
        from example_interfaces.action import Fibonacci_GetResult_Request
        from std_srvs.srv import Trigger, Trigger_Event, Trigger_Response
        print([Trigger_Event, Trigger_Response] == [Trigger.Event, Trigger.Response])
        print(Fibonacci_FeedbackMessage is Fibonacci.Impl.FeedbackMessage)
        print(Fibonacci_GetResult_Request is Fibonacci.Impl.GetResultService.Request)
    """
    exec(textwrap.dedent(program), {})
    assert capsys.readouterr().out.split() == ['True'] * 3
    with pytest.raises(ImportError, match='did you mean Trigger'):
        exec('from std_srvs.srv import Trigger_Reqest', {})


def test_an_unknown_attribute_is_an_attribute_error_as_in_any_module() -> None:
    import std_msgs.msg

    with pytest.raises(AttributeError, match=r"module 'std_msgs\.msg' has no attribute 'Nope'"):
        _ = std_msgs.msg.Nope  # type: ignore[attr-defined]


def test_types_are_built_only_when_asked_for(tmp_path: Path) -> None:
    program = """\
        import visualization_msgs.msg as m
        from goalwire.idl import classes
        before = len(classes._classes)
        m.UVCoordinate
        print(before, len(classes._classes))
    """
    assert output_of(program, cwd=tmp_path) == '0 1'


def test_the_finder_is_installed_once_just_before_the_path_finder() -> None:
    hook.install()
    kinds = [finder if isinstance(finder, type) else type(finder) for finder in sys.meta_path]
    assert kinds.count(hook.InterfaceFinder) == 1
    assert kinds.index(hook.InterfaceFinder) == [kind.__name__ for kind in kinds].index('PathFinder') - 1


def test_an_interpreter_starts_with_nothing_heavy_and_without_a_search(tmp_path: Path) -> None:
    program = """\
        import sys
        import json, socket  # of Python's own library
        ours = sorted(name for name in sys.modules if name.startswith('goalwire'))
        heavy = {'typing', 'pathlib', 'dataclasses', 'numpy'} & set(sys.modules)
        print(ours, heavy)
    """
    start = output_of(program, cwd=tmp_path)
    assert start == '[] set()'


@pytest.mark.parametrize('name', ['sitecustomize_of_ours', 'apport_python_hook', 'org'])
def test_what_every_python_tries_to_import_starts_no_search(name: str, tmp_path: Path) -> None:
    """apport_python_hook is asked for by the sitecustomize.py of Debian's and Ubuntu's Python."""
    program = f"""\
        import sys
        try:
            import {name}
        except ImportError:
            print('goalwire.idl.search_path' in sys.modules)
    """
    assert output_of(program, cwd=tmp_path) == str(name == 'sitecustomize_of_ours')


def test_a_hook_that_is_called_by_hand_needs_no_pth(tmp_path: Path) -> None:
    program = """\
        import sys
        sys.path.append(sys.argv[1])
        from goalwire.idl import hook
        hook.install()
        from std_msgs.msg import String
        import importlib.util
        print(String.__name__, importlib.util.find_spec('rclpy').origin.startswith(hook.OVERLAY))
    """
    library = str(Path(hook.OVERLAY).parents[1])
    done = run_python(program, library, cwd=tmp_path, options=('-S',))
    assert (done.stdout.strip(), done.stderr) == ('String True', '')


@pytest.mark.parametrize(
    ('line', 'said'),
    [
        ('from std_msgs import String', 'from std_msgs.msg import String'),
        ('from std_msgs import Strng', 'from std_msgs.msg import String'),
        ('import std_msgs.String', 'from std_msgs.msg import String'),
        ('import std_msgs; std_msgs.String', 'from std_msgs.msg import String'),
        ('from std_srvs import SetBool', 'from std_srvs.srv import SetBool'),
        ('from example_interfaces import Fibonacci', 'from example_interfaces.action import Fibonacci'),
        ('import std_msgs.msg.String', 'is a class, not a module; write: from std_msgs.msg import String'),
    ],
)
def test_a_type_that_is_looked_for_in_the_wrong_place_is_shown_the_right_one(line: str, said: str) -> None:
    with pytest.raises((ImportError, AttributeError), match=re.escape(said)):
        exec(line, {})


def test_a_package_says_no_more_of_names_that_it_knows_nothing_of() -> None:
    import std_msgs

    with pytest.raises(AttributeError, match=r"^module 'std_msgs' has no attribute 'nothing'$"):
        _ = std_msgs.nothing  # type: ignore[attr-defined]
    with pytest.raises(ImportError, match=r"^cannot import name 'Nothing' from 'std_msgs' \("):
        exec('from std_msgs import Nothing', {})


@pytest.mark.parametrize('name', ['lamp_interfaces', 'lamp'])
@pytest.mark.parametrize('below', ['', 'src'])
def test_definitions_without_package_xml_are_named_with_what_to_write(
    tmp_path: Path, name: str, below: str
) -> None:
    write_files(tmp_path / below / name, {'msg/Foo.msg': 'int32 x'})
    done = run_python(f'from {name}.msg import Foo', cwd=tmp_path)
    if below and name == 'lamp':  # a name like any other: Python's words
        assert done.stderr.endswith("ModuleNotFoundError: No module named 'lamp'\n")
        return
    manifest = tmp_path / below / name / 'package.xml'
    assert f'write {manifest}, at least <package format="3"><name>{name}</name></package>' in done.stderr
    manifest.write_text(f'<package format="3"><name>{name}</name></package>', encoding='utf-8')
    assert output_of(f'from {name}.msg import Foo; print(Foo().x)', cwd=tmp_path) == '0'


def test_a_folder_of_modules_beside_definitions_stays_a_namespace_package(tmp_path: Path) -> None:
    write_files(tmp_path / 'lamp' / 'msg', {'Foo.msg': 'int32 x', 'inner.py': 'x = 1'})
    assert output_of('import lamp.msg.inner; print(lamp.msg.inner.x)', cwd=tmp_path) == '1'


WITHOUT_A_WALK = """\
    import sys
    from goalwire.idl import workspace
    asked, scan = [], workspace.scan
    workspace.scan = lambda root, **how: asked.append(root) or scan(root, **how)
    try:
        {statement}
    except ImportError:
        pass
    print(len(asked))
"""


@pytest.mark.parametrize(
    ('statement', 'walks'),
    [
        ('import lamp', 0),
        ('from lamp import helper', 0),
        ('import lamp.helper', 0),
        ('import importlib; importlib.import_module("lamp")', 0),
        ('from lamp import msg', 1),
        ('from lamp.srv import SetLight', 1),
        ('import lamp_interfaces', 1),
        ('import importlib; importlib.import_module("lamp.msg")', 1),
    ],
)
def test_folders_are_walked_over_for_those_alone_who_ask_for_interfaces(
    tmp_path: Path, statement: str, walks: int
) -> None:
    assert output_of(WITHOUT_A_WALK.format(statement=statement), cwd=tmp_path) == str(walks)


def test_a_broken_manifest_warns_nobody_who_asks_for_no_interfaces(tmp_path: Path) -> None:
    write_package(tmp_path / 'lamp', 'lamp', {'msg/A.msg': ''}, manifest='<package>')
    program = 'try:\n    import lump\nexcept ImportError:\n    pass\n'
    assert run_python(program, cwd=tmp_path).stderr == ''
    assert 'is not well-formed' in run_python('import lump.msg', cwd=tmp_path).stderr


def test_the_overlay_of_another_goalwire_is_no_real_rclpy(tmp_path: Path) -> None:
    files = {'overlay/rclpy/__init__.py': '', 'idl/hook.py': ''}
    other = write_files(tmp_path / 'goalwire', files)
    program = 'from std_msgs.msg import String; print(String(data="hello"))'
    shown = output_of(program, cwd=tmp_path, PYTHONPATH=str(other / 'overlay'))
    assert shown == "std_msgs.msg.String(data='hello')"
