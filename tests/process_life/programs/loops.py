"""A program with an event loop of LOOP, which opens ROS WHEN and may handle a signal itself.

Usage: loops.py LOOP WHEN SIGNAL HANDLER

- WHEN: ROS is opened `before` the loop runs, `inside` it, or `after` it has ended.
- HANDLER: the program handles SIGNAL by its loop's own means. The handler is installed `before` ROS is opened
  or `after` that; `none` is installed.

A thread spins a node. Whatever happens is a line. The program leaves when a line comes in by its input.
"""

from __future__ import annotations

import signal
import socket
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor

LOOP, WHEN, _, HANDLER = sys.argv[1:]
NUMBER = signal.Signals[sys.argv[3]]

Install = Callable[[Callable[[], None]], object]


def say(line: str) -> None:
    """Print in one piece: threads speak, too."""
    sys.stdout.write(f'{line}\n')
    sys.stdout.flush()


def handler_ran() -> None:
    say(f'the handler ran, ok {rclpy.ok()}')


def install_plainly(handler: Callable[[], None]) -> None:
    signal.signal(NUMBER, lambda *_: handler())


def open_ros() -> None:
    """Open ROS and spin a node on a thread."""
    rclpy.init()
    node = rclpy.create_node('guest', start_parameter_services=False, enable_rosout=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)

    def spin() -> None:
        try:
            executor.spin()
        except ExternalShutdownException:
            say('the spin was ended')

    thread = threading.Thread(target=spin)
    thread.start()
    spins.append((executor, thread))


def close_ros() -> None:
    executor, thread = spins.pop()
    executor.shutdown()
    thread.join()
    say(f'ok {rclpy.ok()}')
    rclpy.try_shutdown()
    rclpy.uninstall_signal_handlers()


spins: list[tuple[SingleThreadedExecutor, threading.Thread]] = []


def before_the_loop() -> None:
    if WHEN == 'before':
        if HANDLER == 'before':
            install_plainly(handler_ran)
        open_ros()


def in_the_loop(install: Install) -> None:
    if WHEN != 'before' and HANDLER == 'before':
        install(handler_ran)
    if WHEN == 'inside':
        open_ros()
    if WHEN != 'after' and HANDLER == 'after':
        install(handler_ran)
    if WHEN != 'after':
        read_input()


def at_the_end_of_the_loop() -> None:
    on_line.clear()
    say('the loop works')
    if WHEN == 'before':
        close_ros()


def after_the_loop() -> None:
    if WHEN == 'inside':
        close_ros()
    if WHEN == 'after':
        open_ros()
        if HANDLER == 'after':
            install_plainly(handler_ran)
        read_input()
        lines.get()
        close_ros()


is_ready: SimpleQueue[None] = SimpleQueue()
lines: SimpleQueue[str] = SimpleQueue()
on_line: list[Callable[[], object]] = []


def main_threads_state() -> str:
    """Return whether the main thread sleeps, and how often it has gone to sleep."""
    status = Path('/proc/self/status').read_text(encoding='utf-8').splitlines()
    return '\n'.join(line for line in status if line.startswith(('State', 'voluntary')))


def read() -> None:
    """Read the line that ends the program, on a thread of its own."""
    is_ready.get()
    if sys.platform == 'linux':
        # A signal right before a thread falls asleep is not seen before the next one, with and without ROS.
        before = None
        while (now := main_threads_state()) != before or 'S (sleeping)' not in now:
            before = now
            time.sleep(0.05)  # longer than a thread waits for the interpreter's lock without a turn
    say('ready')
    lines.put(sys.stdin.readline())
    for call in on_line:
        call()


def read_input() -> None:
    is_ready.put(None)


def asyncio_body() -> None:
    """Run the default loop of asyncio, or uvloop's."""
    import asyncio

    async def body() -> None:
        loop = asyncio.get_running_loop()
        leave = asyncio.Event()
        on_line.append(lambda: loop.call_soon_threadsafe(leave.set))
        in_the_loop(lambda handler: loop.add_signal_handler(NUMBER, handler))
        if WHEN != 'after':
            await leave.wait()
        at_the_end_of_the_loop()

    if LOOP == 'uvloop':
        import uvloop

        uvloop.run(body())
    else:
        asyncio.run(body())


def trio_body() -> None:
    import trio

    async def body() -> None:
        leave = trio.Event()
        token = trio.lowlevel.current_trio_token()
        on_line.append(lambda: token.run_sync_soon(leave.set))

        async with trio.open_nursery() as nursery:

            def install(handler: Callable[[], None]) -> None:
                receiver = trio.open_signal_receiver(NUMBER)
                signals = receiver.__enter__()

                async def receive() -> None:
                    try:
                        async for _ in signals:
                            handler()
                    finally:
                        receiver.__exit__(None, None, None)

                nursery.start_soon(receive)

            in_the_loop(install)
            if WHEN != 'after':
                await leave.wait()
            at_the_end_of_the_loop()
            nursery.cancel_scope.cancel()

    trio.run(body)


def anyio_body() -> None:
    import anyio
    from anyio.from_thread import BlockingPortal

    async def body() -> None:
        leave = anyio.Event()
        async with BlockingPortal() as portal, anyio.create_task_group() as group:
            on_line.append(lambda: portal.start_task_soon(leave.set))
            installed = anyio.Event()

            def install(handler: Callable[[], None]) -> None:
                async def receive() -> None:
                    with anyio.open_signal_receiver(NUMBER) as signals:
                        installed.set()
                        async for _ in signals:
                            handler()

                group.start_soon(receive)

            if WHEN != 'before' and HANDLER == 'before':
                install(handler_ran)
                await installed.wait()
            if WHEN == 'inside':
                open_ros()
            if WHEN != 'after':
                if HANDLER == 'after':
                    install(handler_ran)
                    await installed.wait()
                read_input()
                await leave.wait()
            at_the_end_of_the_loop()
            group.cancel_scope.cancel()

    anyio.run(body)


def qt_body() -> None:
    """Run Qt's loop, with the usual notifier by which Python gets a turn for its handlers."""
    from PySide6.QtCore import QCoreApplication, QSocketNotifier, QTimer

    application = QCoreApplication([])
    kept: list[Any] = []

    def install(handler: Callable[[], None]) -> None:
        reader, writer = socket.socketpair()
        writer.setblocking(False)
        before = signal.set_wakeup_fd(writer.fileno())
        notifier = QSocketNotifier(reader.fileno(), QSocketNotifier.Type.Read)
        notifier.activated.connect(lambda *_: reader.recv(64))
        kept.extend((reader, writer, notifier, before))
        install_plainly(handler)

    def begin() -> None:
        in_the_loop(install)
        if WHEN == 'after':
            application.quit()

    on_line.append(application.quit)
    QTimer.singleShot(0, begin)
    if WHEN == 'before' and HANDLER == 'before':
        install(handler_ran)
        open_ros()
    else:
        before_the_loop()
    application.exec()
    at_the_end_of_the_loop()
    if kept:
        signal.set_wakeup_fd(kept[-1])


def main() -> None:
    threading.Thread(target=read, daemon=True).start()
    if LOOP != 'qt':
        before_the_loop()
    try:
        {'trio': trio_body, 'anyio': anyio_body, 'qt': qt_body}.get(LOOP, asyncio_body)()
        after_the_loop()
    except* KeyboardInterrupt:  # trio's come in groups
        on_line.clear()
        say('KeyboardInterrupt')
        if spins:
            close_ros()
    say('end')


main()
