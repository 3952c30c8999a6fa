"""republish of image_transport: raw pictures become compressed ones, and those raw ones again."""

from __future__ import annotations

import pytest
from apps.programs.conftest import Run
from helpers.processes import Program

pytest.importorskip('cv2')

CHECK = """
import rclpy
from rclpy.node import Node
from sensor_msgs.msg import CompressedImage, Image

with rclpy.init():
    node = Node('check')
    def show(message):
        print('raw', message.encoding, message.width, message.height, message.header.frame_id,
              bytes(message.data[:3]).hex(), flush=True)
    def show_compressed(message):
        print('compressed', message.format, bytes(message.data[1:4]), flush=True)
    node.create_subscription(Image, 'again', show, 10)
    node.create_subscription(CompressedImage, 'out/compressed', show_compressed, 10)
    rclpy.spin(node)
"""


def test_there_and_back(run: Run, isolated: dict[str, str]) -> None:
    there = ('-r', 'in:=image', '-p', 'out.compressed.format:=png')
    back = ('-r', 'in/compressed:=out/compressed', '-r', 'out:=again')
    run('image_transport', 'republish', 'raw', 'compressed', '--ros-args', *there)
    run('image_transport', 'republish', 'compressed', 'raw', '--ros-args', *back)
    with Program(CHECK, env=isolated) as check:
        run('image_tools', 'cam2image', '--ros-args', '-p', 'frame_id:=eye', '-p', 'width:=64')
        check.expect(r"^compressed bgr8; png compressed bgr8 b'PNG'$")
        check.expect(r'^raw bgr8 64 240 eye [0-9a-f]{6}$')


def test_without_a_target_both_are_published(run: Run, isolated: dict[str, str]) -> None:
    run('image_transport', 'republish', 'raw', '--ros-args', '-r', 'in:=image', '-r', 'out:=again')
    with Program(CHECK, env=isolated) as check:
        run('image_tools', 'cam2image', '--ros-args', '-p', 'width:=64')
        check.expect_each(r'^compressed bgr8; jpeg compressed bgr8 ', r'^raw bgr8 64 240 ')


@pytest.mark.parametrize(
    ('words', 'reason'),
    [
        (('theora',), "there is no transport 'theora': choose raw or compressed"),
        (('raw', 'raw', 'raw'), 'there are 3 arguments; give two transports at most'),
        (('raw', '--ros-args', '-p', 'out.compressed.format:=gif'), "there is no format 'gif'"),
    ],
)
def test_what_does_not_fit_is_refused(run: Run, words: tuple[str, ...], reason: str) -> None:
    program = run('image_transport', 'republish', *words)
    assert program.wait() == 1
    assert f'republish: {reason}' in program.output
