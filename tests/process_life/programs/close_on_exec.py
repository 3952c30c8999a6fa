"""An executed program inherits no descriptor and no variable of the session."""

from __future__ import annotations

import os
import subprocess
import sys

import rclpy
from forked import expect

LOOK = r"""
import os
for each in sorted(os.listdir('/proc/self/fd'), key=int):
    try:
        target = os.readlink('/proc/self/fd/' + each)
    except OSError:
        continue  # that of the listing
    if int(each) > 2:
        print(each, target)
"""


def inherited() -> list[str]:
    done = subprocess.run([sys.executable, '-c', LOOK], close_fds=False, capture_output=True, check=True)
    return done.stdout.decode().splitlines()


variables = dict(os.environ)
before = inherited()
rclpy.init()
node = rclpy.create_node('close_on_exec')
expect('variables', {name for name in os.environ if os.environ[name] != variables.get(name)}, set())
expect('inherited', inherited(), before)
node.destroy_node()
rclpy.shutdown()
print('good')
