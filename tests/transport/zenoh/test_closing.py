"""Opening, closing, forking and leaving, in processes of their own."""

from __future__ import annotations

import importlib.util
import os
import signal
import sys
from pathlib import Path

import pytest
from helpers.processes import Program
from helpers.wires import opens_native

from goalwire.transport.zenoh import threads
from goalwire.transport.zenoh.settings.environment import CHOICE, ECLIPSE

PREAMBLE = """
    import os, sys, threading
    from goalwire.errors import ClosedError, ForkedError
    from goalwire.rules.qos import QoS
    from goalwire.transport.contract import Endpoint, EndpointKind, NodeName, SessionOptions
    from goalwire.transport.zenoh import TRANSPORT

    HASH = 'RIHS01_' + 'a1' * 32

    def endpoint(kind, name):
        return Endpoint(kind, name, 'std_msgs/msg/String', HASH, QoS())

    def open_session():
        return TRANSPORT.open(SessionOptions(int(os.environ['ROS_DOMAIN_ID'])))
"""

needs_fork = pytest.mark.skipif(not hasattr(os, 'fork'), reason='this system has no fork')


def program(body: str, env: dict[str, str]) -> Program:
    return Program(_dedent(PREAMBLE) + _dedent(body), env=env)


def _dedent(text: str) -> str:
    return '\n'.join(line.removeprefix('    ') for line in text.splitlines()) + '\n'


def test_importing_the_transport_does_not_import_zenoh(world: dict[str, str]) -> None:
    with program("print('zenoh' in sys.modules)", world) as running:
        assert running.succeed() == 'False'


def test_opening_imports_none_of_the_heavy_modules(world: dict[str, str]) -> None:
    body = """
    session = open_session()
    session.node(NodeName('n')).client(endpoint(EndpointKind.CLIENT, '/s'))
    print(sorted({'numpy', 'asyncio', 'yaml', 'rich'} & set(sys.modules)))
    session.close()
    """
    with program(body, world) as running:
        assert running.succeed() == '[]'


def test_a_session_that_is_never_closed_ends_with_the_program(world: dict[str, str]) -> None:
    body = """
    session = open_session()
    node = session.node(NodeName('n'))
    got = threading.Event()
    node.subscription(endpoint(EndpointKind.SUBSCRIPTION, '/t'), lambda sample: got.set())
    node.publisher(endpoint(EndpointKind.PUBLISHER, '/t')).publish(b'x')
    assert got.wait(60)
    """
    with program(body, world) as running:
        assert running.succeed() == ''


def test_a_program_may_end_while_a_daemon_thread_closes(world: dict[str, str]) -> None:
    body = """
    session = open_session()
    node = session.node(NodeName('n'))
    for number in range(50):
        node.subscription(endpoint(EndpointKind.SUBSCRIPTION, f'/t{number}'), print)
    threading.Thread(target=session.close, daemon=True).start()
    while not session.state.closed:
        pass
    print('bye', flush=True)
    """
    with program(body, world) as running:
        assert running.succeed() == 'bye'


def test_a_program_may_end_while_daemon_threads_publish(world: dict[str, str]) -> None:
    """They are inside zenoh when the interpreter ends, and find it closed."""
    body = """
    session = open_session()
    node = session.node(NodeName('n'))
    got = threading.Event()
    node.subscription(endpoint(EndpointKind.SUBSCRIPTION, '/t'), lambda sample: got.set())
    publisher = node.publisher(endpoint(EndpointKind.PUBLISHER, '/t'))

    def flood():
        try:
            while True:
                publisher.publish(b'x' * 100)
        except ClosedError:
            pass

    for _ in range(2):
        threading.Thread(target=flood, daemon=True).start()
    assert got.wait(60)
    print('bye', flush=True)
    """
    for _ in range(5):
        with program(body, world) as running:
            assert running.succeed() == 'bye'


FLOOD = """
    session = open_session()
    node = session.node(NodeName(sys.argv[1]))
    first = threading.Event()
    node.subscription(endpoint(EndpointKind.SUBSCRIPTION, '/t'), lambda sample: first.set())
    publisher = node.publisher(endpoint(EndpointKind.PUBLISHER, '/t'))
"""


@pytest.mark.slow
def test_leaving_while_messages_pour_in_is_clean_each_time(world: dict[str, str]) -> None:
    """Without a close, the interpreter ends while zenoh's threads want to run callbacks."""
    flood = (
        _dedent(PREAMBLE)
        + _dedent(FLOOD)
        + "print('up', flush=True)\nwhile True: publisher.publish(b'x' * 100)\n"
    )
    leave = _dedent(PREAMBLE) + _dedent(FLOOD) + "assert first.wait(10)\nprint('bye', flush=True)\n"
    with Program(flood, 'flood', env=world) as flooding:
        flooding.expect('up')
        for _ in range(5):
            with Program(leave, 'leave', env=world) as leaving:
                assert leaving.succeed() == 'bye'


@needs_fork
def test_a_forked_child_is_told_that_the_session_is_not_its_own(world: dict[str, str]) -> None:
    body = """
    session = open_session()
    node = session.node(NodeName('n'))
    publisher = node.publisher(endpoint(EndpointKind.PUBLISHER, '/t'))
    client = node.client(endpoint(EndpointKind.CLIENT, '/s'))

    def refused(use):
        try:
            use()
        except ForkedError as error:
            return 'child' in str(error)
        return False

    child = os.fork()
    if child == 0:
        uses = [
            lambda: publisher.publish(b'x'),
            lambda: client.request(b'x', print, print),
            lambda: node.publisher(endpoint(EndpointKind.PUBLISHER, '/u')),
            lambda: session.node(NodeName('m')),
            lambda: session.watch_graph(None),
            open_session,
        ]
        print('child', [refused(use) for use in uses], flush=True)
        publisher.close()
        node.close()
        session.close()
        sys.exit(3)
    print('code', os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)
    publisher.publish(b'still works')
    session.close()
    print('parent done')
    """
    # from Python 3.12 on, fork warns of the threads that Zenoh has started
    with program(body, {**world, 'PYTHONWARNINGS': 'ignore::DeprecationWarning'}) as running:
        output = running.succeed()
    refuses_opening = not opens_native()  # eclipse-zenoh cannot be started again there
    assert output.splitlines() == [f'child {[True] * 5 + [refuses_opening]}', 'code 3', 'parent done']


@needs_fork
def test_a_child_forked_before_anything_was_opened_is_free(world: dict[str, str]) -> None:
    body = """
    child = os.fork()
    session = open_session()
    session.node(NodeName('n'))
    session.close()
    if child:
        print('code', os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    """
    with program(body, world) as running:
        assert running.succeed() == 'code 0'


def test_a_subprocess_works_beside_an_open_session(world: dict[str, str]) -> None:
    body = """
    import subprocess
    session = open_session()
    done = subprocess.run([sys.executable, '-c', 'print("hello")'], capture_output=True, text=True)
    print(done.stdout.strip())
    session.close()
    """
    with program(body, world) as running:
        assert running.succeed() == 'hello'


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == 'win32', reason='signals')
def test_ctrl_c_at_any_moment_of_opening_ends_the_program(world: dict[str, str]) -> None:
    body = """
    open_session().close()  # imports: where a SIGINT comes in an eval(), CPython ends by it, caught or not
    threading._dangling = set()  # Python's WeakSet of threads loses a SIGINT that comes as a thread is freed
    try:
        print('opening', flush=True)
        while True:
            open_session().close()
    except KeyboardInterrupt:
        print('interrupted')
    """
    for _ in range(10):
        with program(body, world) as running:
            running.expect('opening')
            running.send_signal(signal.SIGINT)
            assert 'interrupted' in running.succeed()  # within 10 s, or so long does zenoh's router close


def test_pinning_can_be_turned_off(world: dict[str, str]) -> None:
    body = """
    from goalwire.transport.zenoh import threads
    assert threads.keep_thread_state.__name__ == '_nothing'
    got = threading.Event()
    one, two = open_session(), open_session()
    one.node(NodeName('a')).subscription(endpoint(EndpointKind.SUBSCRIPTION, '/t'), lambda sample: got.set())
    publisher = two.node(NodeName('b')).publisher(endpoint(EndpointKind.PUBLISHER, '/t'))
    while not got.wait(0.01):
        publisher.publish(b'x')
    print('heard')
    """
    with program(body, {**world, 'GOALWIRE_PIN_THREADS': '0'}) as running:
        assert running.succeed() == 'heard'


def test_zenohs_logs_follow_rust_log(world: dict[str, str]) -> None:
    with program('open_session().close()', {**world, CHOICE: ECLIPSE, 'RUST_LOG': 'zenoh=debug'}) as running:
        assert 'DEBUG' in running.succeed()


def test_without_rust_log_nothing_is_written(world: dict[str, str]) -> None:
    with program('open_session().close()', world) as running:
        assert running.succeed() == ''


def test_the_parts_of_zenoh_that_are_silenced_are_still_called_that() -> None:
    """Their names in the installed library; an upgrade that moves them brings the noise back."""
    library = importlib.util.find_spec('zenoh.zenoh')
    assert library is not None
    assert library.origin is not None
    code = Path(library.origin).read_bytes()
    assert [part for part in threads.NOISY if part.encode() not in code] == []


def test_a_session_may_live_on_another_thread_than_the_main_one(world: dict[str, str]) -> None:
    body = """
    def work():
        session = open_session()
        session.node(NodeName('n'))
        session.close()
        print('done')
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()
    """
    with program(body, world) as running:
        assert running.succeed() == 'done'
