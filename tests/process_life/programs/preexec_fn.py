"""After shutdown, subprocesses with preexec_fn and pipes start, as those without it do."""

from __future__ import annotations

import subprocess
import sys

import rclpy
from forked import expect


def nothing() -> None:
    """Do nothing between fork and exec; Python forks in its own way for it."""


rclpy.init()
node = rclpy.create_node('preexec_fn')
node.destroy_node()
rclpy.shutdown()
failures = []
for _ in range(int(sys.argv[1]) if sys.argv[1:] else 10):
    try:
        done = subprocess.run(
            ['/bin/cat'],
            preexec_fn=nothing,
            input=b'through',
            capture_output=True,
            check=True,
            timeout=20,
        )
        expect('output', done.stdout, b'through')
    except (OSError, subprocess.SubprocessError) as error:
        failures.append(str(error))
expect('failures', failures, [])
print('good')
