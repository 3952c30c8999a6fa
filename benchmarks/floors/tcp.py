"""The floor of all: bytes sent to another Python process and back over TCP, with nothing between."""

from __future__ import annotations

import socket
from threading import Thread

from benchmarks import stage
from benchmarks.line import Figures

SIZE = 64


def receive(connection: socket.socket) -> bytes:
    """Return the next message; empty where the other end has closed."""
    message = connection.recv(SIZE)
    while message and len(message) < SIZE:
        message += connection.recv(SIZE - len(message))
    return message


def answer(port: int) -> None:
    """Send everything back."""
    connection = socket.create_connection(('127.0.0.1', port))
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def echo() -> None:
        while message := receive(connection):
            connection.sendall(message)

    thread = Thread(target=echo)
    thread.start()
    stage.obey({})
    thread.join()
    connection.close()


def ask(_work: str, count: int) -> Figures:
    with (
        socket.create_server(('127.0.0.1', 0)) as listener,
        stage.Partner('benchmarks.floors.tcp', listener.getsockname()[1]) as partner,
        listener.accept()[0] as connection,
    ):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        message = bytes(SIZE)

        def exchange() -> None:
            connection.sendall(message)
            receive(connection)

        return stage.round_trips(exchange, count, partner)


if __name__ == '__main__':
    stage.run(ask, answer)
