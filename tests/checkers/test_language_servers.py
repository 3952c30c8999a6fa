"""Completion and hover at forty places of the tutorials' programs, by two language servers.

pylsp stands for what jedi is in (vim, IPython, Jupyter), pyright's server for VS Code.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import pytest
from helpers.environments import Environment
from helpers.language_server import LanguageServer
from helpers.markdown import DOCS, ROOT, blocks

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.timeout(600)]

ENOUGH = {'pylsp': 35, 'pyright': 38}
"""jedi looks for no types behind a protocol. So it knows neither what a service answers (`response.`,
`future.result().`) nor what a goal's result is (`answer.result.`), and it shows no text for `answer.result`
and `.value`.
"""


class Place(NamedTuple):
    """A place in a program: the cursor stands behind `text`, of which the program has one."""

    program: str
    text: str
    offered: str
    """A name that completion has to offer there."""


PLACES = [
    Place('lamp.py', '\nrclpy.', 'init'),
    Place('lamp.py', '        self.create_', 'create_service'),
    Place('lamp.py', 'from rclpy.node import ', 'Node'),
    Place('lamp.py', 'from std_srvs.srv import ', 'SetBool'),
    Place('lamp.py', '        self.get_logger().', 'info'),
    Place('press.py', 'node = rclpy.', 'create_node'),
    Place('press.py', 'client = node.', 'create_client'),
    Place('press.py', 'if not client.', 'wait_for_service'),
    Place('press.py', '    response = client.', 'call'),
    Place('press.py', 'client.call(SetBool.', 'Request'),
    Place('press.py', 'print(response.', 'message'),
    Place('press.py', 'SetBool.Request(', 'data='),
    Place('press_async.py', 'future = client.', 'call_async'),
    Place('press_async.py', 'print(future.', 'result'),
    Place('press_async.py', 'print(future.result().', 'message'),
    Place('press_async.py', 'rclpy.spin_', 'spin_until_future_complete'),
    Place('counter.py', 'from example_interfaces.action import ', 'Fibonacci'),
    Place('counter.py', 'from rclpy.action import ', 'ActionServer'),
    Place('counter.py', '        return GoalResponse.', 'ACCEPT'),
    Place('counter.py', '        return CancelResponse.', 'ACCEPT'),
    Place('counter.py', 'return Fibonacci.', 'Result'),
    Place('counter.py', 'Fibonacci.Feedback(', 'sequence='),
    Place('count.py', 'from action_msgs.msg import ', 'GoalStatus'),
    Place('count.py', 'if not client.', 'wait_for_server'),
    Place('count.py', 'sending = client.', 'send_goal_async'),
    Place('count.py', 'Fibonacci.Goal(', 'order='),
    Place('count.py', 'goal = sending.', 'result'),
    Place('count.py', 'if not goal.', 'accepted'),
    Place('count.py', 'getting = goal.', 'get_result_async'),
    Place('count.py', 'answer = getting.', 'result'),
    Place('count.py', "print('Result:', *answer.", 'result'),
    Place('count.py', "print('Result:', *answer.result.", 'sequence'),
    Place('count.py', 'if answer.', 'status'),
    Place('count.py', '== GoalStatus.', 'STATUS_CANCELED'),
    Place('parameters.py', "self.get_parameter('period').", 'value'),
    Place('parameters.py', '        [answer] = self.', 'set_parameters'),
    Place('tf_listener.py', 'found = self.buffer.', 'lookup_transform'),
    Place('tf_listener.py', 'place = found.', 'transform'),
    Place('tf_listener.py', 'place = found.transform.', 'translation'),
    Place('talker.py', 'self.publisher.', 'publish'),
]
"""Every name stands in the program as well: a hover over it has to show what it is."""


@pytest.fixture(scope='module')
def programs() -> dict[str, str]:
    """The texts of the programs by their names."""
    pages = (DOCS / 'tutorials').glob('*.md')
    found = {block.title: block.text for page in pages for block in blocks(page) if block.title}
    for name in ('parameters.py', 'tf_listener.py', 'talker.py'):
        found[name] = (ROOT / 'examples' / name).read_text(encoding='utf-8')
    return found


@pytest.mark.parametrize('server', ['pylsp', 'pyright'])
def test_completion_and_hover(
    checkers: Environment, programs: dict[str, str], tmp_path: Path, server: str
) -> None:
    commands = {'pylsp': ('pylsp',), 'pyright': ('pyright-langserver', '--stdio')}
    tool, *options = commands[server]
    missed = {}
    command: list[str | Path] = [checkers.python.with_name(tool), *options]
    with LanguageServer(command, tmp_path) as editor:
        for number, place in enumerate(PLACES):
            text = programs[place.program]
            assert text.count(place.text) >= 1, place
            before = text[: text.index(place.text) + len(place.text)]
            line, character = before.count('\n'), len(before.rpartition('\n')[2])
            cut = editor.open(f'cut{number}.py', before + text[len(before) :].partition('\n')[1])
            whole = editor.open(f'whole{number}.py', text)
            offered = editor.completions(cut, line, character)
            shown = editor.hover(whole, line, character + 1)
            if place.offered not in offered or (place.offered[-1] != '=' and not shown):
                missed[place] = sorted(offered)[:5], shown[:80]
    assert len(PLACES) - len(missed) >= ENOUGH[server], missed
