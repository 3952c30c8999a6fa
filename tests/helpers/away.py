"""Interfaces that a program under test knows, and the tools beside it do not."""

from __future__ import annotations

from pathlib import Path

from helpers.markdown import ROOT

STRANGER = ROOT / 'tests' / 'apps' / 'cli' / 'programs' / 'stranger.py'
"""A node that uses them: a topic /gauge, a service /tune, an action /sweep."""
_DEFINITIONS = {
    'package.xml': '<package><name>away_interfaces</name><depend>std_msgs</depend></package>',
    'msg/Needle.msg': 'float64 angle\n',
    'msg/Gauge.msg': 'string name\nNeedle needle\nfloat32[3] scale\nuint8[<=4] marks\n',
    'msg/Stamped.msg': 'std_msgs/Header header\nfloat64 value\n',
    'srv/Tune.srv': 'float64 wanted\n---\nfloat64 reached\n',
    'action/Sweep.action': 'int32 sweeps\n---\nint32 sweeps\n---\nfloat32 part\n',
}


def knowing_away(env: dict[str, str], folder: Path) -> dict[str, str]:
    """Write the definitions below a folder; return the environment of programs that know them."""
    package = folder / 'away_interfaces'
    for name, text in _DEFINITIONS.items():
        file = package / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return {**env, 'GOALWIRE_INTERFACE_PATH': str(package)}
