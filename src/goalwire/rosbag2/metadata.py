"""Reads `metadata.yaml` of every version that rosbag2 has had, and writes version 9.

Versions: 3 has compression, 4 the QoS of topics (as YAML within YAML), 5 the files, 6 custom data, 7 type
hashes, 8 the distribution; 9 has QoS policies by name (rosbag2_storage/yaml.hpp).
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import PurePosixPath
from typing import Any

from goalwire.errors import BagError
from goalwire.files import read_regular, show
from goalwire.rosbag2.model import BagFacts, FileFacts, Topic
from goalwire.rules.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoS,
    QoSPolicyEnum,
    ReliabilityPolicy,
)

LARGEST = 2**26
"""The largest size of a `metadata.yaml` that is read, in bytes."""
NEWEST = 9
_NO_TIME = 2**63 - 1
"""The start time that some writers give to an empty bag."""
_S = 1_000_000_000

_POLICIES: tuple[tuple[str, type[QoSPolicyEnum]], ...] = (
    ('history', HistoryPolicy),
    ('reliability', ReliabilityPolicy),
    ('durability', DurabilityPolicy),
    ('liveliness', LivelinessPolicy),
)
_DURATIONS = (
    ('deadline', 'deadline_ns'),
    ('lifespan', 'lifespan_ns'),
    ('liveliness_lease_duration', 'lease_ns'),
)


# -- writing -------------------------------------------------------------------------------------------------


def metadata_text(facts: BagFacts) -> str:
    """Return the text of `metadata.yaml`.

    The file is rewritten every second, so PyYAML, which is slow, does not write it.
    """
    body = bag_text(facts)
    return 'rosbag2_bagfile_information:\n' + ''.join(f'  {line}\n' for line in body.splitlines())


def bag_text(facts: BagFacts) -> str:
    """Return the YAML below the single top-level key of `metadata.yaml`. MCAP files contain the same text."""
    lines = [
        f'version: {NEWEST}',
        f'storage_identifier: {facts.storage}',
        'duration:',
        f'  nanoseconds: {facts.duration}',
        'starting_time:',
        f'  nanoseconds_since_epoch: {facts.start}',
        f'message_count: {facts.count}',
        _head('topics_with_message_count', facts.topics),
    ]
    for topic, count in zip(facts.topics, facts.counts, strict=True):
        lines += [
            '  - topic_metadata:',
            f'      name: {_quote(topic.name)}',
            f'      type: {_quote(topic.type_name)}',
            f'      serialization_format: {_quote(topic.serialization)}',
            f'      {_head("offered_qos_profiles", topic.qos)}',
            *(f'        {line}' for line in qos_lines(topic.qos)),
            f'      type_description_hash: {_quote(topic.type_hash)}',
            f'    message_count: {count}',
        ]
    lines += [
        f'compression_format: {_quote(facts.compression_format)}',
        f'compression_mode: {_quote(facts.compression_mode.upper())}',
        _head('relative_file_paths', facts.files),
        *(f'  - {_quote(file.path)}' for file in facts.files),
        _head('files', facts.files),
    ]
    for file in facts.files:
        lines += [
            f'  - path: {_quote(file.path)}',
            '    starting_time:',
            f'      nanoseconds_since_epoch: {file.start}',
            '    duration:',
            f'      nanoseconds: {file.duration}',
            f'    message_count: {file.count}',
        ]
    lines.append('custom_data:' if facts.custom_data else 'custom_data: ~')
    lines += [f'  {_quote(key)}: {_quote(value)}' for key, value in facts.custom_data]
    lines.append(f'ros_distro: {_quote(facts.ros_distro)}')
    return '\n'.join(lines) + '\n'


def qos_text(profiles: Iterable[QoS]) -> str:
    """Return QoS profiles as MCAP channels and sqlite3 bags store them: a list in YAML, '' for
    no profiles.
    """
    return '\n'.join(qos_lines(profiles))


def qos_lines(profiles: Iterable[QoS]) -> list[str]:
    """Return the lines of a YAML list of QoS profiles, in the form of version 9."""
    lines = []
    for qos in profiles:
        stated = qos.stated()
        lines += [
            f'- history: {stated.history.short_key}',
            f'  depth: {stated.depth}',
            f'  reliability: {stated.reliability.short_key}',
            f'  durability: {stated.durability.short_key}',
            *_duration_lines('deadline', stated.deadline_ns),
            *_duration_lines('lifespan', stated.lifespan_ns),
            f'  liveliness: {stated.liveliness.short_key}',
            *_duration_lines('liveliness_lease_duration', stated.lease_ns),
            f'  avoid_ros_namespace_conventions: {str(stated.avoid_ros_namespace_conventions).lower()}',
        ]
    return lines


def _duration_lines(key: str, nanoseconds: int) -> list[str]:
    seconds, rest = divmod(nanoseconds, _S)
    return [f'  {key}:', f'    sec: {seconds}', f'    nsec: {rest}']


def _head(key: str, items: object) -> str:
    return f'{key}:' if items else f'{key}: []'


def _quote(text: str) -> str:
    return json.dumps(text)  # each string in JSON is a string in YAML, too


def write_metadata(folder: str, facts: BagFacts, name: str) -> None:
    """Replace the metadata file of a bag in one step: a reader finds either the old text or the new text."""
    path = os.path.join(folder, name)
    with open(f'{path}.new', 'w', encoding='utf-8') as file:
        file.write(metadata_text(facts))
    os.replace(f'{path}.new', path)


# -- reading -------------------------------------------------------------------------------------------------


def read_metadata(path: str) -> BagFacts:
    """Read a `metadata.yaml`; raises BagError, FileNotFoundError."""
    try:
        text = read_regular(path, LARGEST).decode('utf-8')
    except FileNotFoundError:
        raise
    except (OSError, UnicodeDecodeError) as error:
        raise BagError(f'{show(path)}: cannot be read: {getattr(error, "strerror", error)}') from error
    found = _load(text, path)
    bag = found.get('rosbag2_bagfile_information') if isinstance(found, dict) else None
    if not isinstance(bag, dict):
        raise BagError(f"{show(path)}: it has no 'rosbag2_bagfile_information', so it belongs to no bag")
    return facts_of(bag, path)


def facts_of_text(text: str, source: str) -> BagFacts:
    """Return the facts in the metadata text of an MCAP file; raises BagError."""
    bag = _load(text, source)
    if not isinstance(bag, dict):
        raise BagError(f'{show(source)}: its metadata is not a YAML map')
    return facts_of(bag, source)


def facts_of(bag: Mapping[str, Any], source: str) -> BagFacts:
    """Return the facts in metadata that YAML was parsed into; raises BagError, which names `source`."""
    try:
        version = int(bag['version'])
        if version > NEWEST:
            raise BagError(
                f'{show(source)}: its metadata has version {version}, and the newest known here is {NEWEST}'
            )
        entries = bag['topics_with_message_count'] or ()
        start = int(bag['starting_time']['nanoseconds_since_epoch'])
        return BagFacts(
            storage=str(bag['storage_identifier']),
            topics=tuple(_topic(entry['topic_metadata']) for entry in entries),
            counts=tuple(int(entry['message_count']) for entry in entries),
            files=_files(bag),
            start=0 if start == _NO_TIME else start,
            duration=max(int(bag['duration']['nanoseconds']), 0),
            compression_format=str(bag.get('compression_format') or ''),
            compression_mode=_mode(bag.get('compression_mode')),
            custom_data=tuple((str(k), str(v)) for k, v in (bag.get('custom_data') or {}).items()),
            ros_distro=str(bag.get('ros_distro') or ''),
            version=version,
        )
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise BagError(f'{show(source)}: its metadata is incomplete or broken ({error!r})') from error


def qos_of_text(text: str) -> tuple[QoS, ...]:
    """Return the QoS profiles in a YAML list; no profiles if the text is broken."""
    try:
        return _profiles(_yaml(text))
    except (ValueError, KeyError, TypeError):
        return ()


def _mode(given: object) -> str:
    mode = str(given or '').lower()
    return '' if mode == 'none' else mode


def _files(bag: Mapping[str, Any]) -> tuple[FileFacts, ...]:
    """Return the bag's files. Metadata before version 5 has only their names; before version 4 these include
    the bag's folder.
    """
    details = {PurePosixPath(each['path']).name: each for each in bag.get('files') or ()}
    found = []
    for path in bag['relative_file_paths'] or ():
        name = PurePosixPath(path).name
        facts = details.get(name)
        if facts is None:
            found.append(FileFacts(name))
            continue
        start = int(facts['starting_time']['nanoseconds_since_epoch'])
        duration = int(facts['duration']['nanoseconds'])
        found.append(
            FileFacts(name, 0 if start == _NO_TIME else start, max(duration, 0), int(facts['message_count']))
        )
    return tuple(found)


def _topic(entry: Mapping[str, Any]) -> Topic:
    offered = entry.get('offered_qos_profiles') or ()
    return Topic(
        str(entry['name']),
        str(entry['type']),
        str(entry.get('type_description_hash') or ''),
        qos_of_text(offered) if isinstance(offered, str) else _profiles(offered),
        serialization=str(entry['serialization_format']),
    )


def _profiles(found: Any) -> tuple[QoS, ...]:
    return tuple(_qos(each) for each in found or ())


def _qos(entry: Mapping[str, Any]) -> QoS:
    policies = {key: _policy(kind, entry.get(key)) for key, kind in _POLICIES}
    durations = {field: _nanoseconds(entry.get(key)) for key, field in _DURATIONS}
    values: dict[str, Any] = policies | durations
    return QoS(
        depth=int(entry.get('depth') or 0),
        avoid_ros_namespace_conventions=bool(entry.get('avoid_ros_namespace_conventions')),
        **values,
    )


def _policy(kind: type[QoSPolicyEnum], value: object) -> QoSPolicyEnum:
    """Return a policy by its name (version 9) or its number (earlier versions); UNKNOWN for any
    other value.
    """
    try:
        return kind[value.upper()] if isinstance(value, str) else kind(int(str(value)))
    except (KeyError, ValueError):
        return kind['UNKNOWN']


def _nanoseconds(given: object) -> int:
    if not isinstance(given, Mapping):
        return 0
    return min(int(given.get('sec') or 0) * _S + int(given.get('nsec') or 0), 2**63 - 1)


def _load(text: str, source: str) -> Any:
    try:
        return _yaml(text)
    except ValueError as error:
        raise BagError(f'{show(source)}: it is not YAML: {error}') from error


def _yaml(text: str) -> Any:
    """Parse YAML; raises ValueError for a broken text."""
    import yaml

    loader = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)
    try:
        return yaml.load(text, Loader=loader)  # noqa: S506 - it is the safe one
    except yaml.YAMLError as error:
        raise ValueError(' '.join(str(error).split())) from None
