"""Layers of the 3D view: how they draw a map, a scan, a path and markers, and where their frames are."""

from __future__ import annotations

import base64
import math
import struct
import zlib

import pytest
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import Marker, MarkerArray

from goalwire.apps.console.state.layers import (
    MOST_MARKERS,
    MOST_POINTS,
    Markers,
    Shape,
    draw_map,
    draw_path,
    draw_scan,
    place_frames,
)
from goalwire.errors import RemoteError
from goalwire.transforms.rigid import Rigid

UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def grid(width: int, height: int, cells: list[int] | bytes) -> OccupancyGrid:
    message = OccupancyGrid()
    message.header.frame_id = '/map'
    message.info.width, message.info.height, message.info.resolution = width, height, 0.5
    message.info.origin.position.x = -3.0
    message.data = cells if isinstance(cells, list) else [*memoryview(cells).cast('b')]
    return message


def pixels(shape: Shape) -> list[list[tuple[int, ...]]]:
    """The rows of a map's picture, from the top, as colours."""
    data = base64.b64decode(shape['picture'].partition(',')[2])
    width, height = struct.unpack('>II', data[16:24])
    at = data.index(b'IDAT')
    (length,) = struct.unpack('>I', data[at - 4 : at])
    data = zlib.decompress(data[at + 4 : at + 4 + length])
    row = 1 + 3 * width  # the filter's byte, and three for each cell
    lines = [data[start + 1 : start + row] for start in range(0, len(data), row)]
    assert len(lines) == height
    return [list(zip(*[iter(line)] * 3, strict=True)) for line in lines]


def test_a_map_has_its_first_row_at_the_lower_edge() -> None:
    drawing = draw_map(grid(2, 2, [0, 100, -1, 50]))
    [shape] = drawing.shapes['map']
    assert (shape['size'], shape['pose'][:3], drawing.note) == ([1.0, 1.0], [-3.0, 0.0, 0.0], '2 x 2 cells')
    unknown, half = pixels(shape)[0]
    assert pixels(shape)[1] == [(255, 255, 255), (0, 0, 0)]
    assert unknown == (112, 137, 134)
    assert half == (128, 128, 128)


def test_a_large_map_is_drawn_coarser_without_losing_a_wall() -> None:
    cells = bytearray(4000 * 4000)
    cells[2 * 4000 + 5] = 100
    message = OccupancyGrid()
    message.info.width = message.info.height = 4000
    message.info.resolution = 0.05
    message.data.frombytes(cells)
    drawing = draw_map(message)
    [shape] = drawing.shapes['']
    assert drawing.note == '4000 x 4000 cells, drawn coarser: 4 x 4 cells as one'
    assert shape['cells'] == [1000, 1000]
    assert shape['size'] == pytest.approx([200.0, 200.0])
    bottom = pixels(shape)[-1]
    assert [x for x, colour in enumerate(bottom) if colour == (0, 0, 0)] == [1]


@pytest.mark.parametrize('resolution', [0.0, -1.0, math.nan, math.inf])
def test_a_map_without_a_size_of_cells_is_refused(resolution: float) -> None:
    message = grid(1, 1, [0])
    message.info.resolution = resolution
    with pytest.raises(RemoteError, match='a cell is'):
        draw_map(message)


def test_a_map_that_lacks_cells_is_refused() -> None:
    with pytest.raises(RemoteError, match='should have 2 x 2 cells, but has 3'):
        draw_map(grid(2, 2, [0, 0, 0]))


def test_a_scan_shows_the_hits_within_its_limits() -> None:
    ranges = [2.0, math.inf, math.nan, 0.05, 9.0, 3.0]
    scan = LaserScan(angle_increment=math.pi / 10, range_min=0.1, range_max=5.0, ranges=ranges)
    scan.header.frame_id = 'laser'
    drawing = draw_scan(scan)
    [shape] = drawing.shapes['laser']
    assert shape['spots'] == [2.0, 0.0, 0.0, 0.0, 3.0, 0.0]
    assert drawing.note == '2 points'


def test_a_scan_of_too_many_rays_is_thinned() -> None:
    scan = LaserScan(angle_increment=1e-5, range_max=5.0, ranges=[1.0] * (MOST_POINTS + 1))
    [shape] = draw_scan(scan).shapes['']
    assert len(shape['spots']) // 3 <= MOST_POINTS


def path_through(*places: float) -> Path:
    path = Path()
    path.header.frame_id = 'map'
    for x in places:
        pose = PoseStamped()
        pose.pose.position.x = x
        path.poses.append(pose)
    return path


def test_a_path_is_a_line_through_its_poses() -> None:
    [shape] = draw_path(path_through(0.0, 1.0, math.nan)).shapes['map']
    assert (shape['kind'], shape['spots']) == ('line', [0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    [empty] = draw_path(path_through()).shapes['map']
    assert empty['spots'] == []


def test_an_arrow_shows_where_a_path_leads_and_the_heading_there() -> None:
    path = path_through(0.0, 1.0)
    path.poses[-1].pose.orientation.z = path.poses[-1].pose.orientation.w = math.sqrt(0.5)
    _, arrow = draw_path(path).shapes['map']
    assert arrow['pose'] == pytest.approx([1.0, 0.0, 0.0, 0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5)], abs=1e-5)


def marker(number: int, kind: int = Marker.CUBE, *, frame: str = 'map', life: int = 0) -> Marker:
    made = Marker(id=number, type=kind)
    made.header.frame_id = frame
    made.lifetime.sec = life
    made.scale.x = 0.5
    return made


def test_markers_are_added_changed_and_deleted() -> None:
    kept = Markers()
    kept.take(MarkerArray(markers=[marker(0), marker(1, Marker.CYLINDER), marker(2, frame='odom')]), 0.0)
    kept.take(marker(0, Marker.SPHERE), 1.0)
    shapes = kept.draw().shapes
    assert [shape['kind'] for shape in shapes['map']] == ['sphere', 'cylinder']
    assert [shape['kind'] for shape in shapes['odom']] == ['box']
    kept.take(Marker(id=1, action=Marker.DELETE), 2.0)
    assert kept.draw().note == '2 markers'
    kept.take(MarkerArray(markers=[Marker(action=Marker.DELETEALL), marker(7)]), 3.0)
    assert kept.draw().note == '1 marker'


def test_a_marker_ends_with_its_lifetime() -> None:
    kept = Markers()
    kept.take(MarkerArray(markers=[marker(0, life=2), marker(1)]), 10.0)
    kept.delete_expired(11.9)
    assert kept.draw().note == '2 markers'
    version = kept.version
    kept.delete_expired(12.0)
    assert kept.draw().note == '1 marker'
    assert kept.version != version


def test_lines_have_their_points_and_width() -> None:
    kept = Markers()
    for number, kind in enumerate((Marker.LINE_STRIP, Marker.LINE_LIST)):
        line = marker(number, kind)
        line.points = [Point(x=1.0), Point(y=2.0)]
        kept.take(line, 0.0)
    found = [(shape['kind'], shape['spots'], shape['width']) for shape in kept.draw().shapes['map']]
    spots = [1.0, 0.0, 0.0, 0.0, 2.0, 0.0]
    assert found == [('line', spots, 0.5), ('segments', spots, 0.5)]


def test_markers_that_are_not_drawn_are_counted() -> None:
    kept = Markers()
    broken, long = marker(1), marker(2, Marker.LINE_LIST)
    broken.pose.position.x = math.nan
    long.points = [Point()] * (MOST_POINTS + 1)
    kept.take(MarkerArray(markers=[marker(0, Marker.TEXT_VIEW_FACING), broken, long, marker(3)]), 0.0)
    drawing = kept.draw()
    assert len(drawing.shapes['map']) == 1
    assert drawing.note.startswith('1 marker; not drawn, since they are too large or have other types: 3')


def test_no_more_markers_are_kept_than_the_limit() -> None:
    kept = Markers()
    kept.take(MarkerArray(markers=[marker(number) for number in range(MOST_MARKERS + 1)]), 0.0)
    drawing = kept.draw()
    assert len(drawing.shapes['map']) == MOST_MARKERS
    assert drawing.note.endswith(f'more than {MOST_MARKERS} are not kept')


def test_frames_are_placed_in_the_fixed_frame() -> None:
    one = Rigid((1.0, 0.0, 0.0), UPRIGHT)
    frames = {'laser': ('odom', one), 'odom': ('map', one), 'other': ('elsewhere', one)}
    assert place_frames(['laser', 'map', 'other'], 'map', frames) == {
        'laser': [2.0, 0.0, 0.0, *UPRIGHT],
        'map': [0.0, 0.0, 0.0, *UPRIGHT],
        'other': None,
    }
