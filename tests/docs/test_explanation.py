"""The drawings and tables of the explanations are those of the code."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from helpers.markdown import DOCS, ROOT, blocks, rows
from rclpy.qos import QoSPresetProfiles

from goalwire.records import replace
from goalwire.rules.goals.states import TABLE, GoalStatus
from goalwire.rules.qos import DurabilityPolicy, LivelinessPolicy, QoS, QoSPolicyEnum, ReliabilityPolicy
from goalwire.rules.qos_compatibility import incompatible_policy
from goalwire.transport.contract import Endpoint, EndpointKind, NodeName
from goalwire.transport.zenoh.ros_keys import data_key, encode_endpoint

EXPLANATION = DOCS / 'explanation'


def test_the_drawing_of_a_goals_life_is_the_table() -> None:
    arrows = [f'[*] --> {GoalStatus.ACCEPTED.name}']
    for status, events in TABLE.items():
        arrows += [f'{status.name} --> {after.name}: {event.name}' for event, after in events.items()]
        if not events:
            arrows.append(f'{status.name} --> [*]')
    [drawing] = [block for block in blocks(EXPLANATION / 'actions.md') if block.language == 'mermaid']
    drawn = [line.strip() for line in drawing.text.splitlines()[1:]]
    assert sorted(drawn) == sorted(arrows)


def test_the_key_and_the_token_of_the_page_are_those_of_the_code() -> None:
    shown = [block.text.strip() for block in blocks(EXPLANATION / 'transport.md') if block.language == 'text']
    shown_key, shown_token = shown
    type_name, type_hash = 'std_msgs/msg/String', shown_key.rpartition('/')[2]
    assert shown_key == data_key(0, '/chatter', type_name, type_hash)
    endpoint = Endpoint(EndpointKind.PUBLISHER, '/chatter', type_name, 'RIHS01_…', QoS(depth=10))
    token = encode_endpoint(0, '<session>', 0, 2, NodeName('talker'), endpoint)
    assert shown_token == token


def _nanoseconds(shown: str) -> int:
    """Read a duration such as '100 ms'; 0 if it is endless."""
    if shown == 'endless':
        return 0
    number, unit = shown.split()
    return int(number) * {'ms': 10**6, 's': 10**9}[unit]


def test_the_presets_of_the_page_on_qos_are_those_of_rclpy() -> None:
    table = rows(EXPLANATION / 'qos.md', 'preset')
    assert len(table) == 7
    for key, depth, reliability, durability, lifespan, _ in table:
        profile = QoSPresetProfiles.get_from_short_key(key.strip('`')).to_core()
        assert profile.depth == int(depth), key
        assert profile.reliability.short_key == reliability.replace(' ', '_'), key
        assert profile.durability.short_key == durability.replace(' ', '_'), key
        assert profile.lifespan_ns == _nanoseconds(lifespan), key


def test_the_pairs_of_the_page_on_qos_match_or_not_as_the_code_says() -> None:
    policies: dict[str, tuple[str, type[QoSPolicyEnum] | None]] = {
        'reliability': ('reliability', ReliabilityPolicy),
        'durability': ('durability', DurabilityPolicy),
        'liveliness': ('liveliness', LivelinessPolicy),
        'deadline': ('deadline_ns', None),
        'lease duration': ('lease_ns', None),
    }

    def profile(policy: str, value: str) -> QoS:
        field, kind = policies[policy]
        if kind is not None:
            return replace(QoS(), **{field: kind[value.upper().replace(' ', '_')]})
        return replace(QoS(), **{field: _nanoseconds(value)})

    table = rows(EXPLANATION / 'qos.md', 'policy | publisher offers')
    assert len(table) == 20
    for policy, offered, requested, match in table:
        found = incompatible_policy(profile(policy, offered), profile(policy, requested))
        assert (match == 'yes') is (found is None), (policy, offered, requested)


def test_the_walks_lead_past_what_there_is() -> None:
    text = (EXPLANATION / 'architecture.md').read_text(encoding='utf-8')
    walks = text[text.index('## Five walks') : text.index('## Decisions')]
    assert walks.count('\n### ') == 10
    steps = re.findall(r'`([\w/]+\.py)`,\s+`([\w.]+)`', walks)
    assert len(steps) > 65
    assert len(steps) == len(re.findall(r'`[\w/]+\.py`', walks))
    for file, name in steps:
        assert name in _defined(ROOT / 'src' / 'goalwire' / file), f'{file} has no {name}'


def test_the_page_on_execution_names_every_file_of_it() -> None:
    text = (EXPLANATION / 'execution.md').read_text(encoding='utf-8')
    folder = ROOT / 'src' / 'goalwire' / 'execution'
    files = {file.relative_to(folder).as_posix() for file in folder.rglob('*.py')}
    named = re.findall(r'`([\w/]+\.py)`', text[text.index('## Where it is in the code') :])
    assert sorted(named) == sorted(file for file in files if not file.endswith('__init__.py'))


def test_the_glossary_names_files_that_there_are() -> None:
    text = (EXPLANATION / 'glossary.md').read_text(encoding='utf-8')
    folder, found = ROOT / 'src' / 'goalwire', 0
    for section in text.split('\n## ')[1:]:
        named = re.search(r'`(\w+)/`', section.partition('\n')[0])
        base = folder if ', ' in section.partition('\n')[0] or named is None else folder / named[1]
        for row in re.findall(r'^\| .*\|$', section, re.MULTILINE):
            for file in re.findall(r'`([\w/]+(?:\.py|/))`', row.rstrip('| ').rpartition('|')[2]):
                assert (base / file).exists(), f'{file}: {row}'
                found += 1
    assert found > 30


@pytest.mark.parametrize('folder', ['zenoh/protocol', 'zenoh/io', 'transport/zenoh/settings'])
def test_the_list_of_a_folders_modules_names_each_once(folder: str) -> None:
    package = ROOT / 'src' / 'goalwire' / folder
    text = (package / '__init__.py').read_text(encoding='utf-8')
    modules = {file.stem for file in package.glob('*.py')} - {'__init__'}
    assert sorted(re.findall(r'^    (\w+) {2,}\S', text, re.MULTILINE)) == sorted(modules)


def _defined(file: Path) -> set[str]:
    """The functions and classes of a file, and the methods of its classes."""
    kinds = ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef
    top = [node for node in ast.parse(file.read_text(encoding='utf-8')).body if isinstance(node, kinds)]
    inner = {f'{node.name}.{part.name}' for node in top for part in node.body if isinstance(part, kinds)}
    return {node.name for node in top} | inner
