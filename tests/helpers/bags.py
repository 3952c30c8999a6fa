"""Bags that tests write: two topics with numbered messages, and what is in one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from std_msgs.msg import Int32, String

from goalwire.cdr.codec import encoder
from goalwire.rosbag2.model import Message
from goalwire.rosbag2.reader import Reader
from goalwire.rosbag2.writer import Writer
from goalwire.rules.qos import DurabilityPolicy, QoS

START = 1_700_000_000_000_000_000
MS = 1_000_000
LATCHED = QoS(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
NUMBERS, WORDS = '/numbers', '/words'


def number(value: int) -> bytes:
    return encoder(Int32)(Int32(data=value))


def word(text: str) -> bytes:
    return encoder(String)(String(data=text))


def add_topics(bag: Writer) -> None:
    bag.add_topic(NUMBERS, 'std_msgs/msg/Int32', qos=[QoS(depth=7)])
    bag.add_topic(WORDS, 'std_msgs/msg/String', qos=[LATCHED])


def put(bag: Writer, value: int) -> None:
    """Write the message of a number, and every tenth time a word, a millisecond apart."""
    bag.write(NUMBERS, number(value), START + value * MS, START + value * MS - 5, value + 1)
    if value % 10 == 0:
        bag.write(WORDS, word(f'at {value}'), START + value * MS + 1)


def write_bag(path: Path, count: int = 100, **options: Any) -> Path:
    with Writer(path, **options) as bag:
        add_topics(bag)
        for value in range(count):
            put(bag, value)
    return path


def contents(path: Path) -> list[tuple[str, int, bytes]]:
    with Reader(path) as bag:
        return [(message.topic, message.time, message.data) for message in bag.messages()]


def expected(count: int = 100) -> list[tuple[str, int, bytes]]:
    found = []
    for value in range(count):
        found.append((NUMBERS, START + value * MS, number(value)))
        if value % 10 == 0:
            found.append((WORDS, START + value * MS + 1, word(f'at {value}')))
    return found


def files_of(path: Path) -> list[Path]:
    return sorted(path.glob('*.mcap'), key=lambda file: int(file.stem.rpartition('_')[2]))


def messages_of(path: Path) -> list[Message]:
    with Reader(path) as bag:
        return list(bag.messages())
