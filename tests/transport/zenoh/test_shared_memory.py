"""Programs written for rclpy exchange pictures through shared memory, and need not know."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from helpers.isolation import isolated_env
from helpers.processes import Program
from helpers.zenoh_memory import segments_of

from goalwire.zenoh.io.shared_memory.segments import IS_SUPPORTED

pytestmark = pytest.mark.skipif(not IS_SUPPORTED, reason='shared memory is for Linux')

WATCHER = """
import sys
import zlib
from array import array
import rclpy
from sensor_msgs.msg import Image

with_views = sys.argv[1] == 'views'
held = []

def show(image):
    data = image.data
    kind = type(data).__name__
    whole = zlib.crc32(data) == image.height and image.width == len(data)
    if with_views:
        held.append(image)
        del held[:-3]
    else:
        data[0] = 255  # it is the program's own
        data.append(1)
    print(f'{image.header.frame_id} {kind} {whole}', flush=True)

rclpy.init()
node = rclpy.create_node('watcher')
options = {'views': True} if with_views else {}
node.create_subscription(Image, 'pictures', show, 50, **options)
print('ready', flush=True)
rclpy.spin(node)
"""

CAMERA = """
import os
import sys
import zlib
from array import array
import rclpy
from rclpy.qos import HistoryPolicy, QoSProfile
from sensor_msgs.msg import Image

rclpy.init()
node = rclpy.create_node('camera')
# If a reader is slow, a publisher with KEEP_LAST drops messages; one with KEEP_ALL waits for the reader.
publisher = node.create_publisher(Image, 'pictures', QoSProfile(history=HistoryPolicy.KEEP_ALL))
while not publisher.get_subscription_count():
    rclpy.spin_once(node, timeout_sec=0.05)

def name(image, number):
    image.header.frame_id = str(number)
    image.height, image.width = zlib.crc32(image.data), len(image.data)

for number in range(40):
    if sys.argv[1] == 'loans':
        with publisher.borrow_loaned_message(data=200_000 + number) as loan:
            loan.get().data[:] = os.urandom(200_000 + number)
            name(loan.get(), number)
            publisher.publish(loan)
    else:
        image = Image(data=array('B', os.urandom(200_000 + number)))
        name(image, number)
        publisher.publish(image)
        image.data[0] ^= 255  # after it was published: the others see what it was before
print('sent', flush=True)
rclpy.spin(node)
"""


@contextmanager
def programs(kind: str, source: str, choice: str) -> Iterator[tuple[Program, Program]]:
    env = isolated_env('rmw_zenoh_cpp') | {'GOALWIRE_SHARED_MEMORY': choice}
    with Program(WATCHER, kind, env=env) as watcher:
        watcher.expect('ready')
        with Program(CAMERA, source, env=env) as camera:
            yield watcher, camera


@pytest.mark.parametrize(('kind', 'of'), [('arrays', 'array'), ('views', 'memoryview')])
@pytest.mark.parametrize(('source', 'choice'), [('own', 'on'), ('loans', 'on'), ('loans', 'off')])
def test_pictures_arrive_whole_in_order_and_as_the_program_asks_for_them(
    kind: str, of: str, source: str, choice: str
) -> None:
    with programs(kind, source, choice) as (watcher, camera):
        for number in range(40):
            watcher.expect(f'^{number} {of} True')
        camera.expect('sent')
        pool = [path for path in segments_of(camera.pid) if path.stat().st_size > 1 << 20]
        assert bool(pool) == (choice == 'on')
