"""The results of `pip install goalwire` and `pip install -e .`, in environments of their own."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from helpers.environments import Environment
from helpers.fresh import output_of
from helpers.isolation import isolated_env
from helpers.packages import write_package
from helpers.processes import Program

from .conftest import build

pytestmark = [pytest.mark.slow, pytest.mark.timeout(300)]

FIRST_LINE = (
    'from humanoid_interfaces.srv import GetJointState; print(GetJointState.Request(joint_name="elbow"))'
)
JOINT = {'srv/GetJointState.srv': 'string joint_name\n---\nfloat64 position\n'}


FROM_NO_WORKSPACE = """\
    import importlib.util, os, sys
    from std_msgs.msg import String
    print(String(data="hello"))
    print(sys.path[-1] == os.path.dirname(os.path.dirname(importlib.util.find_spec('rclpy').origin)))
"""


@pytest.mark.parametrize('kind', ['wheel', 'editable_wheel'])
def test_interfaces_are_a_programs_first_lines_and_the_overlay_comes_last_in_the_path(
    request: pytest.FixtureRequest, new_environment: Callable[[], Environment], tmp_path: Path, kind: str
) -> None:
    installed = new_environment()
    done = installed.install('--no-deps', '--no-compile', str(request.getfixturevalue(kind)))
    assert done.returncode == 0, done.stderr
    write_package(tmp_path / 'ws' / 'src' / 'interfaces', 'humanoid_interfaces', JOINT)
    shown = output_of(FIRST_LINE, cwd=tmp_path / 'ws', python=installed.python)
    assert shown == "humanoid_interfaces.srv.GetJointState_Request(joint_name='elbow')"
    shown = output_of(FROM_NO_WORKSPACE, cwd=tmp_path, python=installed.python)
    assert shown.splitlines() == ["std_msgs.msg.String(data='hello')", 'True']


def test_the_wheel_requires_what_the_library_imports_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        metadata = next(name for name in archive.namelist() if name.endswith('.dist-info/METADATA'))
        lines = archive.read(metadata).decode().splitlines()
    required = {line.removeprefix('Requires-Dist: ') for line in lines if line.startswith('Requires-Dist: ')}
    always = {re.split(r'[^\w-]', each)[0] for each in required if 'extra ==' not in each}
    assert always == {'numpy', 'pyyaml', 'xxhash'}


def test_an_uninstall_leaves_nothing_behind(new_environment: Callable[[], Environment], wheel: Path) -> None:
    environment = new_environment()
    before = environment.files()
    assert environment.install('--no-deps', '--no-compile', str(wheel)).returncode == 0
    assert environment.uninstall('goalwire').returncode == 0
    assert environment.files() == before


def test_the_wheel_writes_nothing_outside_its_own_folder_but_the_pth(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        pth = archive.read('goalwire.pth').decode()
    top = {name.partition('/')[0] for name in names}
    assert {name for name in top if not name.endswith('.dist-info')} == {'goalwire', 'goalwire.pth'}
    assert pth.splitlines()[0] == 'goalwire/overlay'
    assert 'goalwire/py.typed' in names
    assert 'goalwire/idl/share/std_msgs/msg/String.msg' in names
    assert 'goalwire/apps/cli/templates/package/launch/@package@.launch.py.template' in names
    assert {'goalwire/overlay/std_msgs/msg/__init__.pyi', 'goalwire/overlay/std_msgs/py.typed'} <= set(names)


BUILT = {'goalwire/overlay/std_msgs/msg/__init__.pyi', 'goalwire/entities/standard_hashes.py'}


def test_a_wheel_has_the_files_that_the_build_makes(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        assert set(archive.namelist()) >= BUILT
        assert b'class String:' in archive.read('goalwire/overlay/std_msgs/msg/__init__.pyi')


def test_an_editable_install_makes_them_in_the_checkout(editable_wheel: Path, checkout: Path) -> None:
    assert editable_wheel.exists()
    assert {name for name in BUILT if (checkout / 'src' / name).exists()} == BUILT


def test_a_source_archive_has_none_of_them_and_gives_the_same_wheel(
    sdist: Path, wheel: Path, tmp_path: Path
) -> None:
    with tarfile.open(sdist) as archive:
        archive.extractall(tmp_path, filter='data')
    (unpacked,) = tmp_path.iterdir()
    assert not {name for name in BUILT if (unpacked / 'src' / name).exists()}
    again = build('wheel', unpacked, tmp_path)
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(again) as other:
        assert {each.filename: each.CRC for each in one.infolist()} == {
            each.filename: each.CRC for each in other.infolist()
        }


def test_the_build_looks_at_no_definitions_but_the_shipped_ones(checkout: Path, tmp_path: Path) -> None:
    write_package(tmp_path / 'std_msgs', 'std_msgs', {'msg/String.msg': 'int32 other\n'})
    source = tmp_path / 'source'
    shutil.copytree(checkout, source)
    program = f'import runpy; runpy.run_path({str(source / "tools" / "generate.py")!r}, run_name="__main__")'
    output_of(program, cwd=tmp_path, GOALWIRE_INTERFACE_PATH=str(tmp_path), PYTHONPATH=str(tmp_path))
    text = (source / 'src/goalwire/overlay/std_msgs/msg/__init__.pyi').read_text(encoding='utf-8')
    assert 'other' not in text


SERVER = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger

def answer(request, response):
    response.success = True
    return response

rclpy.init()
node = Node('server')
node.create_service(Trigger, 'ask', answer)
print('ready', flush=True)
rclpy.spin(node)
"""
ASKS = """
import sys, rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger

with rclpy.init():
    node = Node('client')
    client = node.create_client(Trigger, 'ask')
    assert client.wait_for_service(20)
    future = client.call_async(Trigger.Request())
    rclpy.spin_until_future_complete(node, future, timeout_sec=20)
    print(future.result().success, 'zenoh' in sys.modules)
"""
NEEDS = ('numpy', 'numpy.libs', 'yaml', '_yaml', 'xxhash')


def test_two_programs_meet_and_a_call_is_answered_with_nothing_else_installed(
    new_environment: Callable[[], Environment], wheel: Path
) -> None:
    """Of the tests' own packages it has those that the wheel requires, and so no eclipse-zenoh."""
    environment = new_environment()
    assert environment.install('--no-deps', '--no-compile', str(wheel)).returncode == 0
    own = next(Path(entry) for entry in sys.path if entry.endswith('site-packages'))
    for name in NEEDS:
        if (own / name).exists():
            (environment.site / name).symlink_to(own / name)
    env = isolated_env('rmw_zenoh_cpp') | {'GOALWIRE_ZENOH': 'native'}
    with Program(SERVER, env=env, python=environment.python) as server:
        server.expect('ready')
        with Program(ASKS, env=env, python=environment.python) as client:
            assert client.succeed() == 'True False'
        server.kill()
    command = [str(environment.python), '-m', 'goalwire', 'router']
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "run pip install 'goalwire[eclipse]'" in done.stderr
    assert 'Traceback' not in done.stderr
