"""Bags in the formats of other tools: Parquet as pyarrow reads it, and pictures as Pillow does."""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped
from helpers.bags import START, write_bag
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage, Image, JointState
from std_msgs.msg import ByteMultiArray, Empty, String

from goalwire.apps.bag.exporting.folders import file_stems
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.main import run_command
from goalwire.rosbag2.writer import Writer


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def export(arguments: str) -> int:
    return run_command('ros2', ['bag', 'export', *arguments.split()])


def write(path: Path, *messages: tuple[str, Any]) -> None:
    """Write messages a ms apart; the topics' types are those of the messages."""
    with Writer(path) as bag:
        for at, (topic, message) in enumerate(messages):
            package, kind = type(message).__module__.split('.')[:2]
            bag.add_topic(topic, f'{package}/{kind}/{type(message).__name__}')
            bag.write(topic, serialize_message(message), START + at * 1_000_000)


def read_parquet(path: Path) -> Any:
    return pytest.importorskip('pyarrow.parquet').read_table(path)


# -- Parquet -------------------------------------------------------------------------------------------------


def test_parquet_has_a_typed_column_for_each_field(here: Path) -> None:
    pose = PoseWithCovarianceStamped()
    pose.header.stamp.sec, pose.header.frame_id = 7, 'map'
    pose.pose.pose.position.x = 1.5
    pose.pose.covariance[35] = 0.25
    write(here / 'bag', ('/robot/pose', pose), ('/robot/pose', PoseWithCovarianceStamped()))
    assert export('bag --format parquet') == Outcome.OK
    table = read_parquet(here / 'bag_parquet' / 'robot__pose.parquet')
    types = {field.name: str(field.type) for field in table.schema}
    assert (types['time'], types['sent']) == ('timestamp[ns, tz=UTC]', 'timestamp[ns, tz=UTC]')
    assert (types['header.stamp.sec'], types['header.stamp.nanosec']) == ('int32', 'uint32')
    assert (types['header.frame_id'], types['pose.pose.position.x']) == ('string', 'double')
    assert types['pose.covariance'].startswith('list<')
    first, second = table.to_pylist()
    assert (first['header.frame_id'], first['pose.pose.position.x']) == ('map', 1.5)
    assert first['pose.covariance'] == [0.0] * 35 + [0.25]
    assert table['time'].cast('int64').to_pylist() == [START, START + 1_000_000]
    assert second['header.stamp.sec'] == 0


def test_parquet_nests_what_lists_of_messages_have(here: Path) -> None:
    status = DiagnosticStatus(level=b'\x02', name='motor', values=[KeyValue(key='t', value='70')])
    write(
        here / 'bag',
        ('/diagnostics', DiagnosticArray(status=[status])),
        ('/bytes', ByteMultiArray(data=[b'\x01', b'\xff'])),
        ('/joints', JointState(name=['a', 'b'], position=[0.5, -1.0])),
        ('/nothing', Empty()),
    )
    assert export('bag --format parquet -o out') == Outcome.OK
    (row,) = read_parquet(here / 'out' / 'diagnostics.parquet').to_pylist()
    assert row['status'] == [
        {
            'level': 2,
            'name': 'motor',
            'message': '',
            'hardware_id': '',
            'values': [{'key': 't', 'value': '70'}],
        }
    ]
    assert read_parquet(here / 'out' / 'bytes.parquet')['data'].to_pylist() == [b'\x01\xff']
    (row,) = read_parquet(here / 'out' / 'joints.parquet').to_pylist()
    assert (row['name'], row['position'], row['velocity']) == (['a', 'b'], [0.5, -1.0], [])
    assert read_parquet(here / 'out' / 'nothing.parquet').column_names == ['time', 'sent']


def test_parquet_of_many_messages_has_each_once(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_bag(here / 'bag', 25_000)
    assert export('bag --format parquet --topics /numbers') == Outcome.OK
    assert "bag_parquet/numbers.parquet' has 25,000 rows" in capsys.readouterr().err
    table = read_parquet(here / 'bag_parquet' / 'numbers.parquet')
    assert table['data'].to_pylist() == list(range(25_000))


def test_a_missing_pyarrow_is_told(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_bag(here / 'bag', 1)
    monkeypatch.setitem(sys.modules, 'pyarrow', None)
    monkeypatch.setitem(sys.modules, 'pyarrow.parquet', None)
    assert export('bag --format parquet') == Outcome.FAILED
    assert "pip install 'goalwire[parquet]'" in capsys.readouterr().err
    assert not (here / 'bag_parquet').exists()


# -- pictures ------------------------------------------------------------------------------------------------


def image(encoding: str, pixels: np.ndarray[Any, Any], padding: int = 0) -> Image:
    """Return a picture whose rows have `padding` bytes behind their pixels."""
    rows = pixels.reshape(pixels.shape[0], -1)
    data = np.pad(rows.view(np.uint8), ((0, 0), (0, padding)))
    return Image(
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding=encoding,
        step=data.shape[1],
        data=data.tobytes(),
    )


def pictures(folder: Path) -> Iterator[np.ndarray[Any, Any]]:
    pillow = pytest.importorskip('PIL.Image')
    for path in sorted(folder.iterdir()):
        yield np.asarray(pillow.open(path))


RAMP = np.arange(4 * 5 * 4, dtype=np.uint8).reshape(4, 5, 4)
DEEP = np.arange(20, dtype=np.uint16).reshape(4, 5) * 3000


@pytest.mark.parametrize(
    ('encoding', 'pixels', 'expected'),
    [
        ('rgb8', RAMP[..., :3], RAMP[..., :3]),
        ('bgr8', RAMP[..., :3], RAMP[..., 2::-1]),
        ('8UC3', RAMP[..., :3], RAMP[..., 2::-1]),
        ('rgba8', RAMP, RAMP),
        ('bgra8', RAMP, RAMP[..., [2, 1, 0, 3]]),
        ('mono8', RAMP[..., 0], RAMP[..., 0]),
        ('mono16', DEEP, DEEP),
        ('16UC1', DEEP, DEEP),
    ],
)
def test_pictures_keep_every_bit(
    here: Path, encoding: str, pixels: np.ndarray[Any, Any], expected: np.ndarray[Any, Any]
) -> None:
    write(here / 'bag', ('/camera/image', image(encoding, np.ascontiguousarray(pixels), padding=6)))
    assert export('bag --format images') == Outcome.OK
    folder = here / 'bag_images' / 'camera__image'
    assert [path.name for path in folder.iterdir()] == [f'{START}.png']
    (found,) = pictures(folder)
    assert (found == expected).all()


def _jpeg() -> bytes:
    pillow = pytest.importorskip('PIL.Image')
    file = io.BytesIO()
    pillow.fromarray(RAMP[..., :3]).save(file, 'jpeg')
    return file.getvalue()


def test_compressed_pictures_are_written_as_they_are(here: Path) -> None:
    data = _jpeg()
    write(
        here / 'bag',
        ('/front/compressed', CompressedImage(format='rgb8; jpeg compressed bgr8', data=data)),
        ('/words', String(data='no picture')),
        ('/front/compressed', CompressedImage(format='jpeg', data=data)),
    )
    assert export('bag --format images') == Outcome.OK
    files = sorted((here / 'bag_images' / 'front__compressed').iterdir())
    assert [path.name for path in files] == [f'{START}.jpg', f'{START + 2_000_000}.jpg']
    assert files[0].read_bytes() == data


def test_the_time_of_a_picture_is_its_name(here: Path) -> None:
    write(here / 'bag', ('/camera', image('mono8', RAMP[..., 0].copy())))
    assert export('bag --format images') == Outcome.OK
    (path,) = (here / 'bag_images' / 'camera').iterdir()
    assert datetime.fromtimestamp(int(path.stem) / 1e9, UTC) == datetime.fromtimestamp(START / 1e9, UTC)


def test_pictures_that_no_file_can_have_are_counted(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = image('rgb8', RAMP[..., :3].copy())
    broken.height = 400
    write(
        here / 'bag',
        ('/depth', image('32FC1', np.ones((2, 2), np.float32))),
        ('/depth', image('32FC1', np.ones((2, 2), np.float32))),
        ('/depth', image('16UC1', DEEP)),
        ('/broken', broken),
        ('/film', CompressedImage(format='h264', data=b'\0\0\0\1gB')),
    )
    assert export('bag --format images') == Outcome.FAILED
    told = capsys.readouterr().err
    assert "depth' has 1 pictures" in told
    assert "depth': 2 pictures are left out: PNG cannot hold the numbers of 32FC1" in told
    assert "broken': 1 pictures are left out: a picture of 5 x 400 in rgb8" in told
    assert "film': 1 pictures are left out: 'h264' is not a picture" in told


def test_a_bag_without_pictures_is_told(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_bag(here / 'bag', 1)
    assert export('bag --format images') == Outcome.NOT_FOUND
    assert "'bag' has no pictures" in capsys.readouterr().err


# -- names ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ('topics', 'stems'),
    [
        (['/arm/joints', '/tf'], ['arm__joints', 'tf']),
        (['/a/b', '/a__b', '/A/b'], ['a__b', 'a__b_2', 'A__b_3']),
    ],
)
def test_each_topic_has_a_file_of_its_own(topics: Sequence[str], stems: Sequence[str]) -> None:
    assert list(file_stems(topics).values()) == stems
