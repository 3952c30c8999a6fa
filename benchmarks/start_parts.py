"""The cost of the parts of a start, in fresh processes: goalwire.pth, `import rclpy`, a node. The least, µs.

usage: RMW_IMPLEMENTATION=goalwire_memory python -m benchmarks.start_parts ask REPEATS
"""

from __future__ import annotations

import subprocess
import sys
import sysconfig

from benchmarks import spinning, stage
from benchmarks.line import Figures

PARTS = ('pth', 'import', 'node')
PROGRAM = """
import os, site, sys
from time import process_time

folder = sys.argv[1]
sys.path.append(folder)
for name in sorted(os.listdir(folder)):
    if name.endswith('.pth') and name != 'goalwire.pth':
        site.addpackage(folder, name, None)
times = [process_time()]
site.addpackage(folder, 'goalwire.pth', None)
times.append(process_time())
import rclpy
times.append(process_time())
rclpy.init()
node = rclpy.create_node('bench_start')
times.append(process_time())
print(*(after - before for before, after in zip(times, times[1:])))
node.destroy_node()
rclpy.shutdown()
"""
"""Run without `site`, so that it can take the time of its work on one .pth alone."""


def ask(repeats: int) -> Figures:
    """Run it a few times after a first one, which leaves byte code behind."""
    command = [sys.executable, '-S', '-c', PROGRAM, sysconfig.get_path('purelib')]
    runs = []
    for _ in range(repeats + 1):
        done = subprocess.run(
            command, check=True, stdout=subprocess.PIPE, text=True, timeout=spinning.PATIENCE_S
        )
        runs.append([float(text) * 1e6 for text in done.stdout.split()])
    return {part: min(run[at] for run in runs[1:]) for at, part in enumerate(PARTS)}


if __name__ == '__main__':
    stage.run(ask, lambda: None)
