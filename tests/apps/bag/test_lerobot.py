"""Bags as datasets of LeRobot: their frames, and the dataset as the package lerobot reads it.

lerobot is too large for the environment of the tests. The tests of the whole command run if it is installed.
"""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import TwistStamped
from helpers.bags import START
from helpers.command_line import executable
from helpers.patience import COMMAND
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage, Image, JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from goalwire.apps.bag.exporting.frames import Episode, Frame
from goalwire.apps.bag.exporting.lerobot_dataset import features_of
from goalwire.apps.bag.exporting.numbers import reader_of
from goalwire.apps.bag.exporting.survey import Choice, Layout, Survey
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.main import run_command
from goalwire.errors import BagError
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer

MS = 1_000_000
READER = Path(__file__).parent / 'programs' / 'read_lerobot.py'
needs_lerobot = pytest.mark.skipif(find_spec('lerobot') is None, reason='lerobot is not installed')


def type_of(message: Any) -> str:
    package, kind = type(message).__module__.split('.')[:2]
    return f'{package}/{kind}/{type(message).__name__}'


def write(path: Path, messages: Iterable[tuple[int, str, Any]], **options: Any) -> Path:
    """Write messages, each with its time in ms after the start and its topic."""
    with Writer(path, **options) as bag:
        for at, topic, message in sorted(messages, key=lambda each: each[0]):
            bag.add_topic(topic, type_of(message))
            bag.write(topic, serialize_message(message), START + at * MS)
    return path


def joints(at: int, topic: str = '/joint_states', **positions: float) -> tuple[int, str, JointState]:
    return at, topic, JointState(name=list(positions), position=list(positions.values()))


def picture(shade: int, height: int = 4, width: int = 6) -> Image:
    """A picture whose upper half is of one red, and whose lower half has the shade."""
    pixels = np.full((height, width, 3), shade, np.uint8)
    pixels[: height // 2] = 200, 0, 0
    return Image(height=height, width=width, encoding='rgb8', step=width * 3, data=pixels.tobytes())


def compressed(kind: str, mode: str = 'RGB') -> CompressedImage:
    pillow = pytest.importorskip('PIL.Image')
    file = io.BytesIO()
    pillow.new(mode, (6, 4), 77).save(file, kind)
    return CompressedImage(format=kind, data=file.getvalue())


def layout_of(choice: Choice, *paths: Path) -> Layout:
    survey = Survey(choice)
    for path in paths:
        with Reader(path) as bag:
            survey.look(bag)
    return survey.layout()


def frames_of(path: Path, layout: Layout, offset_ms: int = 0) -> list[Frame]:
    with Reader(path) as bag:
        return list(Episode(bag, layout, bag.start + offset_ms * MS).frames())


def values(frames: list[Frame], feature: str) -> list[list[float]]:
    return [frame[feature].tolist() for frame in frames]


# -- features ------------------------------------------------------------------------------------------------


def test_the_features_are_those_of_the_topics(tmp_path: Path) -> None:
    path = write(
        tmp_path / 'bag',
        [
            *(joints(at, elbow=at / 1000, wrist=1.0) for at in range(0, 1000, 10)),
            *((at, '/front/image_raw', picture(at % 200)) for at in range(0, 1000, 33)),
            *((at, '/command', Float64MultiArray(data=[1.0, 2.0, 3.0])) for at in range(5, 1000, 50)),
        ],
    )
    layout = layout_of(Choice(action='/command', names=(('/front/image_raw', '/front'),)), path)
    assert layout.fps == 30
    assert features_of(layout, has_videos=True) == {
        'observation.state': {'dtype': 'float32', 'shape': (2,), 'names': ['elbow', 'wrist']},
        'action': {'dtype': 'float32', 'shape': (3,), 'names': ['data.0', 'data.1', 'data.2']},
        'observation.images.front': {
            'dtype': 'video',
            'shape': (4, 6, 3),
            'names': ['height', 'width', 'channels'],
        },
    }
    assert layout_of(Choice(fps='/joint_states'), path).fps == 100
    assert layout_of(Choice(fps=15, wants=lambda *_: False), path).cameras == ()


def test_cameras_with_similar_names_have_features_of_their_own(tmp_path: Path) -> None:
    path = write(tmp_path / 'bag', [joints(0, a=1.0), (0, '/a/b', picture(1)), (1, '/a_b', picture(2))])
    layout = layout_of(Choice(fps=10), path)
    assert [(camera.topic, camera.feature) for camera in layout.cameras] == [
        ('/a/b', 'observation.images.a_b'),
        ('/a_b', 'observation.images.a_b_2'),
    ]


@pytest.mark.parametrize(
    ('message', 'numbers'),
    [
        (JointState(name=['a', 'b'], position=[1.0, 2.0], velocity=[3.0, 4.0]), {'a': 1.0, 'b': 2.0}),
        (JointState(name=['a', 'b'], velocity=[3.0, 4.0]), {'a': 3.0, 'b': 4.0}),
        (JointState(name=['a']), {}),
        (
            JointTrajectory(
                joint_names=['a', 'b'],
                points=[
                    JointTrajectoryPoint(positions=[1.0, 2.0]),
                    JointTrajectoryPoint(positions=[3.0, 4.0]),
                ],
            ),
            {'a': 3.0, 'b': 4.0},
        ),
        (JointTrajectory(joint_names=['a']), {}),
        (Float64MultiArray(data=[0.5]), {'data.0': 0.5}),
        (
            TwistStamped(),
            {f'twist.{kind}.{axis}': 0.0 for kind in ('linear', 'angular') for axis in 'xyz'},
        ),
        (String(data='no number'), {}),
    ],
    ids=lambda value: type(value).__name__,
)
def test_messages_give_numbers_by_name(message: Any, numbers: dict[str, float]) -> None:
    assert reader_of(type_of(message), type(message))(message) == numbers


# -- frames --------------------------------------------------------------------------------------------------


def test_frames_have_the_latest_values_of_their_times(tmp_path: Path) -> None:
    path = write(
        tmp_path / 'bag',
        [
            *(joints(at, a=float(at)) for at in range(0, 210, 10)),
            *((at, '/command', Float64MultiArray(data=[float(at)])) for at in (35, 95, 150)),
        ],
    )
    frames = frames_of(path, layout_of(Choice(action='/command', fps=25), path))
    # The first frame is at 35 ms, when there is a command; then every 40 ms.
    assert values(frames, 'observation.state') == [[30.0], [70.0], [110.0], [150.0], [190.0]]
    assert values(frames, 'action') == [[35.0], [35.0], [95.0], [150.0], [150.0]]
    assert {frame['action'].dtype for frame in frames} == {np.dtype(np.float32)}


def test_an_offset_leaves_the_beginning_out(tmp_path: Path) -> None:
    path = write(tmp_path / 'bag', (joints(at, a=float(at)) for at in range(0, 100, 10)))
    frames = frames_of(path, layout_of(Choice(fps=100), path), 70)
    assert values(frames, 'observation.state') == [[70.0], [80.0], [90.0]]


def test_times_of_frames_do_not_drift(tmp_path: Path) -> None:
    path = write(tmp_path / 'bag', (joints(at, a=float(at)) for at in range(10_001)))
    frames = frames_of(path, layout_of(Choice(fps=30), path))
    assert values(frames, 'observation.state') == [[float(n * 1000 // 30)] for n in range(301)]


def test_joints_of_several_publishers_are_one_state(tmp_path: Path) -> None:
    path = write(
        tmp_path / 'bag',
        [
            joints(0, arm=1.0),
            joints(5, leg=2.0, hip=3.0),
            joints(10, arm=4.0),
            joints(20, hip=5.0),
        ],
    )
    layout = layout_of(Choice(fps=100), path)
    assert layout.vectors[0].names == ('arm', 'leg', 'hip')
    assert values(frames_of(path, layout), 'observation.state') == [[1.0, 2.0, 3.0], [4.0, 2.0, 3.0]]


def test_pictures_are_red_green_and_blue(tmp_path: Path) -> None:
    gray = Image(height=4, width=6, encoding='mono8', step=6, data=bytes([9] * 24))
    alpha = np.full((4, 6, 4), 8, np.uint8)
    alpha[..., 0] = 3
    bgra = Image(height=4, width=6, encoding='bgra8', step=24, data=alpha.tobytes())
    path = write(
        tmp_path / 'bag',
        [
            joints(0, a=1.0),
            (0, '/raw', picture(50)),
            (0, '/gray', gray),
            (0, '/bgra', bgra),
            (0, '/png', compressed('png')),
            (0, '/jpeg', compressed('jpeg', 'L')),
            joints(10, a=1.0),
        ],
    )
    frame = frames_of(path, layout_of(Choice(fps=10), path))[0]
    assert frame['observation.images.raw'][0, 0].tolist() == [200, 0, 0]
    assert frame['observation.images.raw'][3, 5].tolist() == [50, 50, 50]
    assert frame['observation.images.gray'][1, 1].tolist() == [9, 9, 9]
    assert frame['observation.images.bgra'][1, 1].tolist() == [8, 8, 3]
    assert frame['observation.images.png'][1, 1].tolist() == [77, 0, 0]
    assert frame['observation.images.jpeg'][1, 1].tolist() == [77, 77, 77]
    assert {frame[key].shape for key in frame if 'images' in key} == {(4, 6, 3)}


def test_pictures_that_cannot_be_used_are_counted_and_old_ones_are_told(tmp_path: Path) -> None:
    broken = compressed('png')
    broken.data = broken.data[:40]
    path = write(
        tmp_path / 'bag',
        [
            *(joints(at, a=1.0) for at in range(0, 3000, 100)),
            (0, '/camera', compressed('png')),
            (200, '/camera', broken),
            (400, '/camera', compressed('png', 'I;16')),
            (600, '/depth', Image(height=4, width=6, encoding='16UC1', step=12, data=bytes(48))),
            (800, '/raw', picture(1)),
            (1000, '/raw', picture(1, width=8)),
        ],
    )
    survey = Survey(Choice(fps=10))
    with Reader(path) as bag:
        survey.look(bag)
        episode = Episode(bag, survey.layout())
        assert len(list(episode.frames())) == 22
    assert survey.unusable == {'/depth': '16UC1 has no colours of 8 bits'}
    first, second, third = episode.left_out()
    assert first.startswith("1 pictures of '/camera' are left out: a png picture is broken: ")
    assert second == (
        "1 pictures of '/camera' are left out: a png picture of the mode I;16 has no colours of 8 bits"
    )
    assert third == "1 pictures of '/raw' are left out: the size is 8 x 4, not 6 x 4"
    # The frames are at 0.8, 0.9 … 2.9 s. The pictures are of 0 s and of 0.8 s.
    assert episode.stale() == [
        "19 frames have a picture of '/camera' that is older than 1 s",
        "11 frames have a picture of '/raw' that is older than 1 s",
    ]


# -- errors --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('messages', 'choice', 'text'),
    [
        (
            [(0, '/words', String())],
            Choice(),
            'has no messages of sensor_msgs/msg/JointState; name',
        ),
        (
            [joints(0, '/left', a=1.0), joints(0, '/right', a=1.0)],
            Choice(),
            'has several topics of sensor_msgs/msg/JointState: /left, /right; name one by --state-topic',
        ),
        ([joints(0, a=1.0)], Choice(action='/command'), "has no messages of '/command'"),
        ([joints(0, a=1.0)], Choice(state='/words'), "has no messages of '/words'"),
        (
            [(0, '/words', String())],
            Choice(state='/words'),
            "has no numbers on '/words', of the type std",
        ),
        ([joints(0, a=1.0)], Choice(), 'has too few messages to take a rate from; give the frames a second'),
        ([joints(0, a=1.0)], Choice(fps='/words'), "has no messages of '/words'"),
    ],
)
def test_what_a_bag_lacks_is_told(
    tmp_path: Path, messages: list[tuple[int, str, Any]], choice: Choice, text: str
) -> None:
    path = write(tmp_path / 'bag', messages)
    with pytest.raises(BagError) as caught:
        layout_of(choice, path)
    assert text in str(caught.value)


def test_the_joint_states_are_the_state_beside_others(tmp_path: Path) -> None:
    path = write(tmp_path / 'bag', [joints(0, '/command', b=1.0), joints(0, a=1.0)])
    assert layout_of(Choice(fps=10), path).vectors[0].topic == '/joint_states'
    assert layout_of(Choice(state='/command', fps=10), path).vectors[0].names == ('b',)


def test_bags_that_do_not_go_together_are_told(tmp_path: Path) -> None:
    first = write(tmp_path / 'first', [joints(0, a=1.0), joints(10, a=1.0), (5, '/camera', picture(1))])
    second = write(tmp_path / 'second', [joints(0, a=1.0, b=2.0)])
    layout = layout_of(Choice(fps=10), first, second)
    with pytest.raises(BagError, match="second' has no topic '/camera', which other bags have"):
        frames_of(second, layout)
    with pytest.raises(BagError, match="first' has no frame: '/joint_states' has no value of b"):
        frames_of(first, layout)


def export(arguments: str) -> int:
    return run_command('ros2', ['bag', 'export', *arguments.split()])


@pytest.mark.skipif(find_spec('lerobot') is not None, reason='lerobot is installed')
def test_a_missing_lerobot_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / 'bag', [joints(0, a=1.0)])
    assert export('bag --format lerobot') == Outcome.FAILED
    assert "needs the package 'lerobot'; run: pip install lerobot" in capsys.readouterr().err
    assert not (tmp_path / 'bag_lerobot').exists()


def test_other_formats_take_one_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write(tmp_path / 'bag', [joints(0, a=1.0)])
    assert export(f'{path} {path} --format csv') == Outcome.USAGE
    assert 'csv takes one bag' in capsys.readouterr().err


# -- the whole command, with lerobot -------------------------------------------------------------------------


def write_demonstrations(folder: Path) -> None:
    """Write two bags of 1 s and of 0.5 s; the second one says its task."""
    for name, length, data in (('first', 1000, {}), ('second', 500, {'task': 'wave'})):
        write(
            folder / name,
            [
                *(joints(at, elbow=at / 1000, wrist=float(length)) for at in range(0, length, 10)),
                *((at, '/front/image', picture(at // 10, 128, 192)) for at in range(0, length, 40)),
                *((at, '/command', Float64MultiArray(data=[float(at)])) for at in range(0, length, 20)),
            ],
            custom_data=data,
        )


def run(cwd: Path, *command: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a program that imports lerobot, which alone takes a command's usual time."""
    env = {**os.environ, 'HF_HUB_OFFLINE': '1'}
    return subprocess.run(
        command, cwd=cwd, env=env, capture_output=True, text=True, timeout=5 * COMMAND, check=False
    )


def make_dataset(cwd: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return run(cwd, executable(), 'bag', 'export', '--format', 'lerobot', '-o', 'data', *arguments)


def read_dataset(folder: Path) -> dict[str, Any]:
    done = run(folder.parent, sys.executable, READER, folder)
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@needs_lerobot
@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize('flags', [['--no-video'], []], ids=['pictures', 'videos'])
def test_lerobot_reads_the_dataset(tmp_path: Path, flags: list[str]) -> None:
    write_demonstrations(tmp_path)
    ended = make_dataset(
        *(tmp_path, 'first', 'second', '--action-topic', '/command', '-m', '/front/image:=/front'),
        *('--robot-type', 'r2', *flags),
    )
    assert ended.returncode == 0, ended.stderr
    assert "'first': 25 frames" in ended.stderr
    assert (
        "'data' has 2 episodes with 38 frames, 25 a second: observation.state (2), action (1), "
        'observation.images.front (192 x 128)'
    ) in ended.stderr
    found = read_dataset(tmp_path / 'data')
    assert (found['fps'], found['episodes'], found['robot']) == (25, 2, 'r2')
    assert found['features']['observation.state'] == {'names': ['elbow', 'wrist'], 'dtype': 'float32'}
    frames = found['frames']
    assert [frame['episode'] for frame in frames] == [0] * 25 + [1] * 13
    assert [frame['task'] for frame in frames] == ['data'] * 25 + ['wave'] * 13
    times = [*range(0, 1000, 40), *range(0, 500, 40)]
    for frame, at in zip(frames, times, strict=True):
        length = 500 if frame['episode'] else 1000
        assert frame['time'] == pytest.approx(at / 1000)
        assert frame['state'] == pytest.approx([at / 1000, length])
        assert frame['action'] == [at]
        pixels = np.array(frame['pixels']['observation.images.front'])
        expected = np.full((128, 192, 3), at // 10)
        expected[:64] = 200, 0, 0
        # The codec of videos blurs the edge in the middle; the first row and the last one are little changed.
        tolerance = 0 if flags else 30
        assert np.abs(pixels[[0, 127]] - expected[[0, 127]]).max() <= tolerance, (at, pixels)


@needs_lerobot
@pytest.mark.slow
def test_a_dataset_is_never_written_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / 'bag', [joints(0, a=1.0)])
    (tmp_path / 'data').mkdir()
    assert export('bag --format lerobot -o data') == Outcome.FAILED
    assert "'data' exists already; choose another folder" in capsys.readouterr().err
    assert list((tmp_path / 'data').iterdir()) == []


@needs_lerobot
@pytest.mark.slow
def test_pictures_that_are_too_small_for_videos_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(tmp_path / 'bag', [joints(0, a=1.0), (0, '/camera', picture(1, 16, 640))])
    assert export('bag --format lerobot --fps 10') == Outcome.FAILED
    told = capsys.readouterr().err
    assert "'/camera' has pictures of 640 x 16, and videos need 32 x 32; use --no-video" in told
    assert not (tmp_path / 'bag_lerobot').exists()


@needs_lerobot
@pytest.mark.slow
@pytest.mark.timeout(600)
def test_episodes_before_a_failure_stay(tmp_path: Path) -> None:
    command = Float64MultiArray(data=[1.0])
    states = [*(joints(at, a=1.0, b=1.0) for at in range(0, 500, 100)), (0, '/command', command)]
    write(tmp_path / 'whole', states)
    write(tmp_path / 'part', [joints(0, b=1.0), (0, '/command', command)])
    ended = make_dataset(tmp_path, 'whole', 'part', '--action-topic', '/command', '--task', 'stand')
    assert ended.returncode == Outcome.FAILED
    assert "'part' has no frame: '/joint_states' has no value of a" in ended.stderr
    found = read_dataset(tmp_path / 'data')
    assert [(frame['state'], frame['task']) for frame in found['frames']] == [([1.0, 1.0], 'stand')] * 5
