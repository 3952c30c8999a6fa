"""Programs that use the names which launch_ros, ros2cli, rosapi, tf2_ros and smach use, in the same way."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from helpers.isolation import isolated_env

PROGRAMS = Path(__file__).parent / 'programs'
OUTPUT = {
    'like_launch_ros': """\
loading demo demo::Talker ['chatter:=/talk'] {'rate': 5}
loaded True /talker 7
changed True
told True
share True
""",
    'like_ros2cli': """\
['success: false', 'message: light True']
['REQUEST_RECEIVED', 'RESPONSE_SENT']
goal 4 [4]
['builtin_interfaces/Time', 'string']
deleted True
without a share folder []
speed is there False
""",
    'like_rosapi': """\
['builtin_interfaces/Time', 'geometry_msgs/Twist', 'geometry_msgs/Vector3', 'std_msgs/Header'] True
([('level', 'octet'), ('name', 'string'), ('message', 'string'), ('hardware_id', 'string'), \
('values', 'diagnostic_msgs/KeyValue')], ['ERROR', 'OK', 'SLOT_TYPES', 'STALE', 'WARN'])
['speed']
2 3
[['std_srvs/srv/Trigger']]
['/robot', '/rosapi']
""",
    'like_smach': """\
STATUS_SUCCEEDED [3]
STATUS_CANCELED [9]
late False
service True
introspected True
""",
    'like_tf2_ros': """\
by the action 2.0
by the client 2.0
refused True
latest True
""",
}


ON_ZENOH = [pytest.param(program, 'rmw_zenoh_cpp') for program in OUTPUT]
ON_DDS = [
    pytest.param(program, 'rmw_cyclonedds_cpp', marks=() if program == 'like_ros2cli' else pytest.mark.long)
    for program in OUTPUT
]
"""The calls are those of rclpy, which knows no wire: the program that looks around most is run on both."""


@pytest.mark.slow
@pytest.mark.parametrize(('program', 'rmw'), ON_ZENOH + ON_DDS)
def test_a_program_that_works_as_the_tool_does_gets_what_it_asks_for(
    program: str, rmw: str, tmp_path: Path
) -> None:
    done = subprocess.run(
        [sys.executable, str(PROGRAMS / f'{program}.py')],
        cwd=tmp_path, env={**isolated_env(rmw), 'XDG_CACHE_HOME': str(tmp_path)},
        capture_output=True, text=True, timeout=50, check=False,
    )  # fmt: skip
    assert (done.stdout, done.returncode) == (OUTPUT[program], 0), done.stderr
