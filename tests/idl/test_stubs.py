from __future__ import annotations

from pathlib import Path

import pytest
from helpers.fresh import run_python
from helpers.packages import write_files, write_package
from helpers.type_checking import type_errors

from goalwire.errors import UnknownInterfaceError
from goalwire.idl import entry_points, hook, search_path, stubs
from goalwire.idl.workspace import KINDS

SHIPPED = sorted(folder.name for folder in Path(search_path.SHIPPED).iterdir())
ARM = {
    'msg/Joint.msg': """\
# A joint.

string name  # as "left knee"
float64 angle 0.5  # [rad] from rest
byte LIMIT=3
uint8 HOME=7
""",
    'msg/Odd.msg': """\
string str
int32[] list
bool bool
byte[2] raw
float32[3] axis
Joint[<=2] joints
wstring w
""",
    'srv/Move.srv': 'Joint to\n---\nbool done\n',
    'action/Wave.action': 'int32 times\n---\nbool done\n---\nint32 so_far\n',
}


@pytest.fixture
def arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the stubs of arm_interfaces."""
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(tmp_path))
    write_package(tmp_path / 'arm_interfaces', 'arm_interfaces', ARM)
    assert stubs.main([str(tmp_path / 'typings'), 'arm_interfaces']) == 0
    return tmp_path / 'typings'


@pytest.mark.parametrize('package', SHIPPED)
def test_the_built_stubs_are_what_the_generator_writes(package: str) -> None:
    folder = Path(hook.OVERLAY) / package
    built = {
        file.relative_to(folder).as_posix(): file.read_text(encoding='utf-8')
        for file in folder.rglob('*.pyi')
    }
    assert built == stubs.package_stubs(package), 'run: python tools/generate.py'


def test_no_stub_can_be_imported_in_place_of_a_package(tmp_path: Path) -> None:
    with_stubs = {file.relative_to(hook.OVERLAY).parts[0] for file in Path(hook.OVERLAY).rglob('*.pyi')}
    assert with_stubs == set(SHIPPED)
    assert [name for name in SHIPPED if list(Path(hook.OVERLAY, name).rglob('*.py'))] == []
    write_files(tmp_path, {'rclpy/__init__.py': ''})  # a real one, without messages of its own
    program = 'import importlib.util\nprint(importlib.util.find_spec("std_msgs"))\nimport std_msgs.msg\n'
    done = run_python(program, cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert done.stdout == 'None\n'
    assert "ModuleNotFoundError: No module named 'std_msgs'" in done.stderr


def test_every_class_of_a_stub_exists_with_the_fields_it_names(arm: Path) -> None:
    from arm_interfaces.action import Wave  # type: ignore[import-not-found]
    from arm_interfaces.msg import Joint, Odd  # type: ignore[import-not-found]

    text = (arm / 'arm_interfaces' / 'msg' / '__init__.pyi').read_text(encoding='utf-8')
    for cls in (Joint, Odd):
        assert f'class {cls.__name__}:' in text
        for field in cls.get_fields_and_field_types():
            assert f' {field}: ' in text
    assert Wave.Impl.SendGoalService.Request.get_fields_and_field_types()


@pytest.mark.slow
def test_a_type_checker_knows_the_shipped_packages(tmp_path: Path) -> None:
    program = """\
        from array import array
        from typing import assert_type
        import numpy
        from control_msgs.action import FollowJointTrajectory
        from diagnostic_msgs.msg import DiagnosticStatus
        from geometry_msgs.msg import PoseStamped
        from numpy.typing import NDArray
        from sensor_msgs.msg import Imu, JointState
        from std_srvs.srv import SetBool
        pose = PoseStamped()
        goal = FollowJointTrajectory.Impl.SendGoalService.Request().goal
        assert_type(pose.pose.position.x, float)
        assert_type(SetBool.Request(data=True).data, bool)
        assert_type(goal, FollowJointTrajectory.Goal)
        assert_type(goal.trajectory.points[0].positions, 'array[float]')
        assert_type(Imu().orientation_covariance, NDArray[numpy.float64])
        level: bytes = DiagnosticStatus.ERROR
        JointState().position = [1.0, 2.0]
    """
    assert type_errors(program, tmp_path) == []


@pytest.mark.slow
def test_a_type_checker_finds_mistakes_in_messages(tmp_path: Path) -> None:
    program = """\
        from geometry_msgs.msg import Pose, Nope
        from std_srvs.srv import SetBool
        Pose().position.x = 'far'
        Pose().positoin
        SetBool.Request(dta=True)
        SetBool.Request(data=[])
    """
    assert type_errors(program, tmp_path) == [
        ('1', 'attr-defined'),
        ('3', 'assignment'),
        ('4', 'attr-defined'),
        ('5', 'call-arg'),
        ('6', 'arg-type'),
    ]


@pytest.mark.slow
def test_a_type_checker_takes_written_stubs_for_a_package_of_one_s_own(arm: Path, tmp_path: Path) -> None:
    program = """\
        from array import array
        from typing import assert_type
        from arm_interfaces.action import Wave
        from arm_interfaces.msg import Joint, Odd
        from arm_interfaces.srv import Move
        def answer(request: Move.Request) -> Move.Response:
            assert_type(request.to.angle, float)
            return Move.Response(done=request.to.name == 'elbow')
        assert_type(Wave.Impl.CancelGoalService.Request().goal_info.stamp.sec, int)
        home: int = Joint.HOME
        odd = Odd(str='a', list=[1], bool=True, raw=[b'a', b'b'], axis=[0.0] * 3, joints=[Joint()], w='b')
        assert_type(odd.list, 'array[int]')
        assert_type(odd.raw, list[bytes])
        assert_type(odd.str, str)
    """
    assert type_errors(program, tmp_path, typings=arm) == []


@pytest.mark.slow
def test_a_type_checker_ties_the_types_of_a_service_together(tmp_path: Path) -> None:
    program = """\
        from typing import Protocol, TypeVar, assert_type
        from std_srvs.srv import SetBool, Trigger
        RequestT = TypeVar('RequestT')
        ResponseT = TypeVar('ResponseT')
        RequestT_co = TypeVar('RequestT_co', covariant=True)
        ResponseT_co = TypeVar('ResponseT_co', covariant=True)
        class Service(Protocol[RequestT_co, ResponseT_co]):
            @property
            def Request(self) -> type[RequestT_co]: ...
            @property
            def Response(self) -> type[ResponseT_co]: ...
        def call(service: type[Service[RequestT, ResponseT]], request: RequestT) -> ResponseT:
            raise NotImplementedError
        assert_type(call(SetBool, SetBool.Request()), SetBool.Response)
    """
    assert type_errors(program, tmp_path) == []


def test_without_package_names_all_that_goalwire_does_not_ship_are_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_package(tmp_path / 'a', 'try_a_msgs', {'msg/A.msg': ''})
    write_package(tmp_path / 'b', 'try_b_msgs', {'srv/B.srv': '---'})
    search_path.discard()
    assert stubs.main(['typings']) == 0
    others = {'try_a_msgs', 'try_b_msgs', *entry_points.registrations()}  # the robot may be installed
    assert {folder.name for folder in (tmp_path / 'typings').iterdir()} == others
    assert 'try_a_msgs, try_b_msgs' in capsys.readouterr().out


def test_folders_can_be_named_as_stub_packages(arm: Path, tmp_path: Path) -> None:
    assert stubs.main(['--stub-packages', str(tmp_path / 'site'), 'arm_interfaces']) == 0
    written = {file.relative_to(tmp_path / 'site').as_posix() for file in (tmp_path / 'site').rglob('*.pyi')}
    assert written == {'arm_interfaces-stubs/__init__.pyi'} | {
        f'arm_interfaces-stubs/{kind}/__init__.pyi' for kind in KINDS
    }


def test_comments_become_documentation(arm: Path) -> None:
    text = (arm / 'arm_interfaces' / 'msg' / '__init__.pyi').read_text(encoding='utf-8')
    assert '    angle: float\n    """[rad] from rest"""\n' in text
    assert 'class Joint:\n    """A joint."""\n' in text
    assert '    name: str\n    """as "left knee\\""""\n' in text


def test_a_missing_package_is_an_error_with_the_places_searched(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(UnknownInterfaceError, match='no interface package named'):
        stubs.package_stubs('try_missing_msgs')
    assert stubs.main(['unused', 'try_missing_msgs']) == 1
    assert search_path.INTERFACE_PATH in capsys.readouterr().err
    assert not Path('unused').exists()


def test_a_malformed_definition_is_an_error_with_file_and_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    package = write_files(tmp_path / 'try_bad_msgs', {'msg/Bad.msg': '\nint33 x\n'})
    monkeypatch.setenv(search_path.INTERFACE_PATH, str(tmp_path))
    assert stubs.main([str(tmp_path / 'typings'), 'try_bad_msgs']) == 1
    assert f'{package / "msg" / "Bad.msg"}:2' in capsys.readouterr().err
