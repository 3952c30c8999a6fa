"""The checks of `ros2 doctor` on the installation: which goalwire and which rclpy programs import here."""

from __future__ import annotations

import subprocess
import sys

import goalwire
from goalwire.apps.cli.commands.doctor.check import Check
from goalwire.apps.cli.framework import installation

_IMPORT_S = 30.0
_RUN = 'python -m goalwire.run prog.py'


def check_goalwire() -> Check:
    """Say where goalwire is imported from, and whether its files are mixed with those of another version."""
    name, here = 'goalwire', f'{goalwire.__version__} in {installation.CODE}'
    found = installation.find_installed()
    if not found:
        told = f'{here}, which is not installed'
        advice = 'pip install goalwire; else programs need the lines of docs/how-to/packaging.md'
        return Check(name, True, told, advice, is_needed=False)
    first, *others = found
    place = installation.place_of(first)
    if not installation.is_imported(first):
        told = f'imported: {here}; installed: {first.version} in {place}'
        source = installation.CODE.parent
        advice = f'take {source} out of PYTHONPATH, or install that one: pip install -e its checkout'
        return Check(name, False, told, advice)
    if others:
        told = f'{here}; another is installed: {others[0].version} in {installation.place_of(others[0])}'
        return Check(
            name, False, told, 'uninstall one of them: pip uninstall goalwire, with the pip of its Python'
        )
    if overlays := installation.other_overlays():
        told = f'{here}; sys.path has the overlay of another one, {overlays[0]}'
        advice = 'a goalwire.pth or PYTHONPATH names it: uninstall the goalwire that it belongs to'
        return Check(name, False, told, advice)
    if first.version != goalwire.__version__:
        told = f'{here}, and pip knows it as {first.version}, in {place}'
        advice = 'the checkout has moved on since it was installed: pip install -e it again'
        return Check(name, False, told, advice)
    return Check(name, True, here)


def check_rclpy() -> Check:
    """Say which rclpy a program imports here, and how to use goalwire instead if it is a different rclpy."""
    name = 'rclpy'
    imported, foreign = installation.find_rclpy(), installation.foreign_rclpy()
    if not imported:
        advice = f'Python did not read goalwire.pth (python -S, or a folder in PYTHONPATH): {_RUN} needs none'
        return Check(name, False, '`import rclpy` finds none', advice)
    if installation.is_other_overlay(imported.parent):
        told = f'`import rclpy` takes that of another goalwire, {imported}'
        return Check(name, False, told, f'{_RUN} takes the one of this goalwire; better: keep one of the two')
    if imported != foreign:
        hidden = f'; GOALWIRE_FIRST=1 puts it before the one in {foreign}' if foreign else ''
        return Check(name, True, f"`import rclpy` takes goalwire's{hidden}")
    if why := _why_not_importable():
        told = f'`import rclpy` takes the one in {imported}, which fails: {why}'
        return Check(name, False, told, f"{_RUN} takes goalwire's; or take the other one out of PYTHONPATH")
    told = f"`import rclpy` takes the one in {imported}, not goalwire's"
    return Check(name, True, told, f"{_RUN} takes goalwire's", is_needed=False)


def _why_not_importable() -> str:
    """Import rclpy in another process; return '' if that works, else the last line of its output."""
    command = [sys.executable, '-c', 'import rclpy']
    try:
        done = subprocess.run(  # noqa: S603
            command, capture_output=True, text=True, errors='replace', timeout=_IMPORT_S, check=False
        )
    except subprocess.TimeoutExpired:
        return f'no end within {_IMPORT_S:.0f} s'
    if done.returncode == 0:
        return ''
    lines = done.stderr.strip().splitlines()
    return lines[-1] if lines else f'exit code {done.returncode}'
