"""Starts programs in children that it forks: each is a process of its own, and rclpy is imported once.

The socket that is its only argument brings a line of JSON for each program, with the descriptors of its
standard streams; the answer is the process id. What a program sees is what `python program.py` gives it:
`__main__`, arguments, environment and working directory.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
from importlib import import_module
from types import ModuleType
from typing import Any

PRELOADED = (
    'example_interfaces.action', 'rclpy', 'rclpy.action', 'rclpy.executors', 'rclpy.node', 'rclpy.parameter',
    'sensor_msgs.msg', 'std_msgs.msg', 'std_srvs.srv',
)  # fmt: skip


def run(request: dict[str, Any], streams: list[int]) -> None:
    """Become the program, in the child, and end as it ends."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    for target, stream in enumerate(streams):
        os.dup2(stream, target)
        os.close(stream)
    os.environ.clear()
    os.environ.update(request['environment'])
    os.chdir(request['folder'])
    name = request['name']
    sys.argv = [name, *request['arguments']]
    sys.path[0] = request['folder']
    main = sys.modules['__main__'] = ModuleType('__main__')
    with open(name, encoding='utf-8') as file:  # noqa: PTH123
        code = compile(file.read(), name, 'exec')
    try:
        exec(code, main.__dict__)
    except SystemExit:
        raise
    except BaseException as error:
        trace = error.__traceback__
        assert trace is not None
        sys.last_value = error
        sys.excepthook(type(error), error, trace.tb_next)
        raise SystemExit(1) from None


def serve(channel: socket.socket) -> None:
    """Fork for each request, until the other end is closed."""
    for module in PRELOADED:
        import_module(module)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for the children
    while True:
        data, streams, _, _ = socket.recv_fds(channel, 1 << 16, 3)
        if not data:
            return
        child = os.fork()
        if child == 0:
            channel.close()
            run(json.loads(data), streams)
            return
        for stream in streams:
            os.close(stream)
        channel.sendall(f'{child}\n'.encode())


if __name__ == '__main__':
    serve(socket.socket(fileno=int(sys.argv[1])))
