"""Which overrides are told to have been of no use, and which are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from goalwire.entities.parameters.files import with_files_read
from goalwire.rules.arguments import parse_arguments
from goalwire.rules.parameters.unused import OverrideUse

FILE = """\
/robot:
  ros__parameters: {speed: 2.0, sped: 3}
/other:
  ros__parameters: {a: 1}
/**:
  ros__parameters: {shared: 1}
"""


def use(*arguments: str) -> OverrideUse:
    made = OverrideUse(with_files_read(parse_arguments(['--ros-args', *arguments])))
    made.note_node('/robot')
    made.declared('/robot', 'speed')
    made.note_node('/ns/arm')
    made.declared('/ns/arm', 'limits.low')
    return made


@pytest.mark.parametrize('rule', ['speed:=1', 'robot:speed:=2', 'limits.low:=3'])
def test_what_some_node_declared_was_used(rule: str) -> None:
    assert use('-p', rule).describe_unused() == []


@pytest.mark.parametrize(
    ('rule', 'said'),
    [
        ('spedd:=1', "nothing used '-p spedd:=…': no node declared spedd; did you mean speed?"),
        ('zz:=1', "nothing used '-p zz:=…': no node declared zz"),
        ('robot:spedd:=1', "'-p robot:spedd:=…': /robot did not declare spedd; did you mean speed?"),
        ('robto:speed:=1', 'there was no node /robto; this program made /robot, /ns/arm'),
        ('arm:limits.low:=1', 'there was no node /arm; this program made /robot, /ns/arm'),
    ],
)  # fmt: skip
def test_what_none_declared_was_not(rule: str, said: str) -> None:
    (text,) = use('-p', rule, '-p', rule).describe_unused()
    assert said in text


def test_nothing_is_said_where_there_never_was_a_node() -> None:
    assert OverrideUse(parse_arguments(['--ros-args', '-p', 'a:=1'])).describe_unused() == []


def test_a_file_may_be_shared_with_other_programs(tmp_path: Path) -> None:
    path = tmp_path / 'all.yaml'
    path.write_text(FILE)
    (text,) = use('--params-file', str(path)).describe_unused()
    used = f"nothing used all of '--params-file {path}', /robot: "
    assert text == f'{used}/robot did not declare sped; did you mean speed?'


def test_a_file_for_none_of_the_nodes_is_told(tmp_path: Path) -> None:
    path = tmp_path / 'arm.yaml'
    path.write_text('/arm:\n  ros__parameters: {speed: 1.0}\n/leg/*:\n  ros__parameters: {a: 1}\n')
    (text,) = use('--params-file', str(path)).describe_unused()
    assert text == (
        f"nothing used '--params-file {path}': it is for /arm, /leg/*; this program made /robot, /ns/arm: "
        'give both the same name'
    )


def test_a_sentence_stays_short(tmp_path: Path) -> None:
    made = use('-p', f'{"x" * 9000}:=1')
    for number in range(500):
        made.note_node(f'/node{number}')
    (text,) = made.describe_unused()
    assert len(text) < 400
