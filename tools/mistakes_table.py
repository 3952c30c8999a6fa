"""Writes the tables of docs/reference/errors-that-help.md: what goalwire and the real rclpy say to mistakes.

The programs are those of tests/mistakes. The texts of goalwire are those that its tests expect; rclpy's are
read from the programs, which run in an environment of their own with the wheels of PyPI:

    python tools/mistakes_table.py FOLDER      # where that environment is kept
    python tools/mistakes_table.py             # goalwire's texts anew, with rclpy's as the page has them
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / 'tests'))

from helpers.environments import Environment  # noqa: E402
from mistakes.catalog import Mistake, read_all  # noqa: E402

PAGE = ROOT / 'docs' / 'reference' / 'errors-that-help.md'
WHEELS = (
    'ros-rclpy[fastrtps]==9.1.2', 'ros-std-msgs==5.5.1', 'ros-std-srvs==5.5.1', 'ros-test-msgs==2.3.0',
    'ros-geometry-msgs==5.5.1', 'ros-sensor-msgs==5.5.1',
)  # fmt: skip
TOPICS = {
    'spinning': 'Nodes and spinning',
    'waiting': 'Services, and waiting for them',
    'holding_up': 'Callbacks that hold up others',
    'messages': 'Messages',
    'parameters': 'Parameters',
    'actions': 'Actions',
    'arguments': 'Arguments and QoS',
    'names': 'Names',
    'interfaces': 'Own interfaces',
    'launch': 'Launch files and the command line',
}
HEAD = '| mistake | goalwire says | where | within | rclpy 9.1.2 says |'
NOTHING = 'nothing'
NO_PART = '—'
"""The mark for parts that the wheels lack: own definitions, launch files, the command line, asyncio."""
_RUNS_S = 15.0
"""How long a program may go on before it gets Ctrl-C, as from a user who waits in vain."""
_ERROR = re.compile(r'^(?!KeyboardInterrupt|.*ExternalShutdown)[\w.]*(Error|Exception|Handle|Warning)\b')
_LOG_HEAD = re.compile(r'^\[(?:WARN|ERROR|INFO)\] \[[\d.]+\] \[[\w.]+\]: ')
_AFTER_CTRL_C = 'context is invalid'
"""A part of what rclpy says to the Ctrl-C that ends a program, and not to its mistake."""
_LONGEST = 300


def ask_rclpy(mistake: Mistake, python: Path) -> str:
    """Run a program under the real rclpy, and return what it says at last."""
    topic = mistake.name.partition('/')[0]
    if topic in {'interfaces', 'launch'}:
        return NO_PART
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / 'program'
        if mistake.file.name == 'program.py':
            shutil.copytree(mistake.file.parent, place)
        else:
            place.mkdir()
        text = mistake.file.read_text(encoding='utf-8')
        if 'import goalwire' in text:
            return NO_PART
        text = text.replace('example_interfaces.action', 'test_msgs.action')
        (place / mistake.file.name).write_text(text, encoding='utf-8')
        domain = str(1 + hash(mistake.name) % 100)
        output, waited = _run([str(python), mistake.file.name, *mistake.arguments], place, domain)
    return _last_words(output, waited=waited)


def _run(command: list[str], folder: Path, domain: str) -> tuple[str, bool]:
    environment = {
        **os.environ,
        'ROS_DOMAIN_ID': domain,
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'RMW_IMPLEMENTATION': 'rmw_fastrtps_cpp',
        'RCUTILS_COLORIZED_OUTPUT': '0',
    }
    process = subprocess.Popen(
        command, cwd=folder, env=environment, text=True, start_new_session=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
    )  # fmt: skip
    assert process.stdout is not None
    stop = partial(os.killpg, process.pid)
    with ThreadPoolExecutor(1) as reader:
        reading = reader.submit(process.stdout.read)
        waited = False
        for number in (signal.SIGINT, signal.SIGKILL):
            try:
                process.wait(_RUNS_S)
                break
            except subprocess.TimeoutExpired:
                waited = True
                stop(number)
        process.wait()
        return reading.result(), waited


def _last_words(output: str, *, waited: bool) -> str:
    """Return the error that ended a program, else its last log line; of one that hangs, that it does."""
    lines = [line for line in output.splitlines() if line.strip()]
    if waited:
        lines = [line for line in lines if _AFTER_CTRL_C not in line]
    errors = [line for line in lines if _ERROR.match(line)]
    logged = [line for line in lines if _LOG_HEAD.match(line)]
    warned = [line.partition('Warning: ')[2] for line in lines if 'Warning: ' in line]
    if waited and not (errors or logged):
        return 'nothing, it goes on until Ctrl-C'
    if 'Segmentation' in output:
        return 'Segmentation fault'
    last = next((line for line in reversed(lines) if line in errors or line in logged), '')
    if last in errors:
        return _masked(last)
    told = [line for line in logged if '[ERROR]' in line] or logged or errors or warned
    return _masked(_told(told[-1], *errors)) if told else NOTHING


def _told(line: str, *errors: str) -> str:
    """Return a line without its head, and with the error that it leaves out."""
    text = _LOG_HEAD.sub('', line)
    return f'{text.rstrip()} {errors[-1]}' if errors and text.rstrip().endswith(':') else text


def _masked(text: str) -> str:
    """Return a text without what differs in each run."""
    return re.sub(r'0x[0-9a-f]{6,}', '0x…', re.sub(r'ID: \[[\d ]+\]', 'ID: […]', text))


def page_with(rclpy_says: dict[str, str]) -> str:
    """Return the page's text with its tables made anew."""
    text = PAGE.read_text(encoding='utf-8')
    tables = []
    for topic, title in TOPICS.items():
        rows = [
            f'| {_cell(each.title)} | {_cell(each.says)} | {each.place or NO_PART} | {each.within:g} s '
            f'| {_cell(rclpy_says[each.name])} |'
            for each in read_all()
            if each.name.startswith(f'{topic}/')
        ]
        tables.append('\n'.join([f'## {title}', '', HEAD, '|---|---|---|---|---|', *rows]))
    return text[: text.index('\n## ') + 1] + '\n\n'.join(tables) + '\n'


def rclpy_cells() -> dict[str, str]:
    """Return rclpy's texts as the page has them, by the titles of the mistakes."""
    rows = [line for line in PAGE.read_text(encoding='utf-8').splitlines() if line.startswith('| ')]
    return {
        row.split(' | ')[0].removeprefix('| '): row.rsplit(' | ', 1)[1].removesuffix(' |') for row in rows
    }


def _cell(text: str) -> str:
    short = text if len(text) <= _LONGEST else text[:_LONGEST] + '…'
    return short.replace('\\|', '|').replace('|', '\\|').replace('<', '&lt;').replace('&amp;', '&')


def main() -> None:
    mistakes = read_all()
    if len(sys.argv) > 1:
        python = Environment.kept(Path(sys.argv[1]), *WHEELS).python
        with ThreadPoolExecutor(4) as pool:
            said = pool.map(partial(ask_rclpy, python=python), mistakes)
            told = {each.name: text for each, text in zip(mistakes, said, strict=True)}
    else:
        known = rclpy_cells()
        told = {each.name: known.get(_cell(each.title), NO_PART) for each in mistakes}
    PAGE.write_text(page_with(told), encoding='utf-8')


if __name__ == '__main__':
    main()
