"""view_frames: draws the tree of frames."""

from __future__ import annotations

import shutil
import subprocess
import sys
import time
from argparse import ArgumentParser
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
import yaml
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.utilities import remove_ros_args
from tf2_ros import Buffer, TransformListener


def draw(frames: Mapping[str, Mapping[str, Any]], when: float) -> str:
    """Return the tree in Graphviz's language; `frames` has the facts of each child frame."""
    lines = ['digraph G {']
    for child, facts in frames.items():
        label = '\\n'.join(
            f'{name}: {facts[key]}'
            for name, key in (
                ('Broadcaster', 'broadcaster'),
                ('Average rate', 'rate'),
                ('Buffer length', 'buffer_length'),
                ('Most recent transform', 'most_recent_transform'),
                ('Oldest transform', 'oldest_transform'),
            )
        )
        lines.append(f'{_quote(facts["parent"])} -> {_quote(child)}[label=" {label}\\n"];')
    roots = {str(facts['parent']) for facts in frames.values()} - {str(child) for child in frames}
    legend = _quote(f'Recorded at time: {when}')
    lines += [
        'edge [style=invis];',
        'subgraph cluster_legend { style=bold; color=black; label="view_frames result";',
    ]
    lines += [f'{legend}[ shape=plaintext ] ;', '}']
    lines += [f'{legend}->{_quote(root)};' for root in sorted(roots)]
    return '\n'.join([*lines, '}\n'])


def _quote(name: str) -> str:
    text = str(name).replace('\\', '\\\\').replace('"', '\\"')
    return f'"{text}"'


def main(argv: Sequence[str] | None = None) -> int:
    """Listen for some seconds, write frames_<date>.gv, and frames_<date>.pdf if Graphviz is installed."""
    arguments = list(sys.argv if argv is None else argv)
    parser = ArgumentParser('view_frames', description='Write the tree of transforms as a picture.')
    parser.add_argument(
        '--wait-time', '-t', type=float, default=5.0, help='seconds to listen, 5 if not given'
    )
    parser.add_argument('-o', '--output', help='name of the files, without an ending')
    words = parser.parse_args(remove_ros_args(arguments)[1:])
    stem = Path(words.output or time.strftime('frames_%Y-%m-%d_%H.%M.%S'))
    try:
        with rclpy.init(args=arguments):
            frames, when = _listen(words.wait_time)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 130
    if not frames:
        print(
            'view_frames: no transform came; is a program that publishes /tf or /tf_static running?',
            file=sys.stderr,
        )
        return 1
    source = stem.with_name(f'{stem.name}.gv')
    source.write_text(draw(frames, when), encoding='utf-8')
    dot = shutil.which('dot')
    if dot is None:
        print(f'{source} is written. A picture needs Graphviz: install it (apt install graphviz), then:')
        print(f'  dot -Tpdf {source} -o {stem}.pdf')
        return 0
    subprocess.run([dot, '-Tpdf', str(source), '-o', f'{stem}.pdf'], check=True)  # noqa: S603
    print(f'Generating graph in {stem}.pdf file...')
    return 0


def _listen(seconds: float) -> tuple[dict[str, dict[str, Any]], float]:
    node = Node('view_frames')
    buffer = Buffer(node=node)
    listener = TransformListener(buffer, node)
    node.get_logger().info(f'Listening to tf data for {seconds} seconds...')
    end = time.monotonic() + seconds
    while (left := end - time.monotonic()) > 0.0:
        rclpy.spin_once(node, timeout_sec=left)
    when = node.get_clock().now().nanoseconds / 1e9
    listener.unregister()
    return yaml.safe_load(buffer.all_frames_as_yaml()) or {}, when
