"""The effect of Jupyter's button Interrupt on ROS: it ends a cell, and nothing else."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from helpers.notebooks import Notebook

pytest.importorskip('ipykernel')
pytestmark = [
    pytest.mark.slow,
    pytest.mark.timeout(400),
    pytest.mark.skipif(sys.platform == 'win32', reason='signals of POSIX'),
]

START = """
import rclpy
from rclpy.node import Node
from std_srvs.srv import SetBool

def switch(request, response):
    response.message = 'on' if request.data else 'off'
    return response

rclpy.init()
node = Node('notebook')
node.create_service(SetBool, 'switch', switch)
client = node.create_client(SetBool, 'switch')
nobody = node.create_client(SetBool, 'nobody')
print('started')
"""
BACKGROUND = """
import threading
threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
"""
CALL = 'client.call(SetBool.Request(data=True)).message'
SPIN = "print('spinning')\nrclpy.spin(node)"


@pytest.fixture(scope='module')
def kernel(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Notebook]:
    """A kernel in a world of its own."""
    from helpers.isolation import NETWORK, isolated_env
    from helpers.notebooks import Notebook

    with Notebook(tmp_path_factory.mktemp('notebook'), isolated_env(NETWORK)) as notebook:
        yield notebook


@pytest.fixture
def notebook(kernel: Notebook) -> Iterator[Notebook]:
    """The kernel; after the test its context is closed, which is faster than to restart it."""
    yield kernel
    kernel.run('rclpy.uninstall_signal_handlers()\nrclpy.try_shutdown()')


def test_an_interrupt_of_the_cell_that_began_with_init_ends_that_cell(notebook: Notebook) -> None:
    output = notebook.run(START + SPIN, interrupted_after='spinning')
    assert output.splitlines() == ['started', 'spinning', 'KeyboardInterrupt: ']
    assert notebook.run('rclpy.ok()') == 'True\n'
    assert notebook.run(BACKGROUND) == ''
    assert notebook.run(CALL) == "'on'\n"


@pytest.mark.parametrize(
    'waiting',
    [
        'rclpy.spin(node)',
        'node.get_clock().sleep_for(rclpy.duration.Duration(seconds=60))',
        'import time; time.sleep(60)',
    ],
)
def test_an_interrupt_of_a_later_cell_leaves_the_context_as_it_is(notebook: Notebook, waiting: str) -> None:
    assert notebook.run(START) == 'started\n'
    assert 'KeyboardInterrupt' in notebook.run(f"print('now')\n{waiting}", interrupted_after='now')
    assert notebook.run('rclpy.ok()') == 'True\n'


def test_an_interrupt_ends_a_call_that_nobody_answers_and_not_the_spinning_thread(notebook: Notebook) -> None:
    notebook.run(START + BACKGROUND)
    output = notebook.run("print('now')\nnobody.call(SetBool.Request())", interrupted_after='now')
    assert 'KeyboardInterrupt' in output
    assert notebook.run(CALL) == "'on'\n"
    assert notebook.run('(await client.call_async(SetBool.Request())).message') == "'off'\n"


def test_a_second_init_says_to_shut_down_first_and_then_works(notebook: Notebook) -> None:
    notebook.run(START)
    assert 'call rclpy.shutdown() first' in notebook.run(START)
    assert notebook.run('rclpy.try_shutdown()\n' + START) == 'started\n'


def test_handlers_that_a_cell_asks_for_are_installed(notebook: Notebook) -> None:
    """A cell that names signals gets their handlers: an interrupt then ends the context, as in a program."""
    asked = START.replace(
        'rclpy.init()', 'rclpy.init(signal_handler_options=rclpy.signals.SignalHandlerOptions.ALL)'
    )
    notebook.run(asked + SPIN, interrupted_after='spinning')
    assert notebook.run('rclpy.ok()') == 'False\n'
    assert 'call rclpy.try_shutdown() first' in notebook.run('rclpy.init()')
