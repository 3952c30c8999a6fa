"""The facts at the head of a report: versions, the machine, and how busy it was."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from helpers import real_rclpy

from benchmarks import ROOT


def facts() -> dict[str, str]:
    """Return what a reader needs to judge the figures."""
    return {
        'goalwire': f'{version("goalwire")}, commit {_commit()}',
        'Python': platform.python_version(),
        'Zenoh': f"goalwire's own session and eclipse-zenoh {_installed('eclipse-zenoh')}, loopback TCP",
        'DDS': f"goalwire's own session and libddsc of cyclonedds {_installed('cyclonedds')}, loopback UDP",
        'rclpy': f'{real_rclpy.NEWEST[0].rpartition("==")[2]} of PyPI, Fast DDS with its shared memory',
        'machine': f'{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.release()}',
        'load before': ' '.join(f'{load:.2f}' for load in os.getloadavg()),
    }


def _installed(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return '(not installed)'


def _commit() -> str:
    git = ['git', '-C', str(ROOT), 'rev-parse', '--short', 'HEAD']
    done = subprocess.run(git, capture_output=True, text=True, check=False)
    return done.stdout.strip() or 'unknown'


def _processor() -> str:
    try:
        lines = Path('/proc/cpuinfo').read_text(encoding='utf-8').splitlines()
    except OSError:
        return platform.machine()
    return next((line.partition(':')[2].strip() for line in lines if line.startswith('model name')), '')
