"""goalwire console: any ROS 2 robot in the browser, until Ctrl-C."""

from __future__ import annotations

import os
from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from goalwire.apps.cli.framework.live import live, until_signal
from goalwire.apps.cli.framework.numbers import port
from goalwire.apps.cli.framework.outcome import CommandError, Outcome
from goalwire.apps.cli.framework.serving import NOT_ENCRYPTED, add_access_options, read_access
from goalwire.apps.cli.framework.verbs import Noun, Verb
from goalwire.security import is_asked_for

if TYPE_CHECKING:
    from collections.abc import Callable

    import goalwire
    from goalwire.apps.cli.framework.output import Output
    from goalwire.apps.console.settings import Settings

TOKEN = 'GOALWIRE_CONSOLE_TOKEN'  # noqa: S105 - the name of the variable


def _arguments(parser: ArgumentParser) -> None:
    ports = parser.add_mutually_exclusive_group()
    ports.add_argument(
        '--port', metavar='N', type=port, default=8420, help='TCP port (8420); 0: any that is free'
    )
    ports.add_argument(
        '--prefer-port', metavar='N', type=port, help='TCP port; if it is taken, any that is free'
    )
    add_access_options(parser, 'browsers', TOKEN, 'https')
    parser.add_argument(
        '--bag', metavar='FOLDER', help='Show this recording, a folder or a file, instead of the live robot'
    )
    parser.add_argument(
        '--record-to', metavar='FOLDER', default='.', help='Folder for new recordings (default: this folder)'
    )
    parser.add_argument(
        '--missions', metavar='FILE', default='', help='Show the missions of this journal, and answer them'
    )
    parser.add_argument('--read-only', action='store_true', help='Only look: send nothing')
    parser.add_argument(
        '--allow',
        metavar='PATTERN',
        action='append',
        default=[],
        help="Send only to names that match (e.g. '/arm/*'); may be repeated",
    )
    parser.add_argument('--view', metavar='NAME', default='', help='Page to open: robot, graph, logs …')
    parser.add_argument('--no-open', action='store_true', help='Open no browser')


def _settings(arguments: Namespace) -> Settings:
    from goalwire.apps.console.settings import VIEWS, Settings

    access = read_access(arguments, TOKEN)
    if arguments.view and arguments.view not in VIEWS:
        raise CommandError(
            Outcome.BAD_VALUE, f"there is no page '{arguments.view}'", f'--view takes: {", ".join(VIEWS)}'
        )
    return Settings(
        access.host,
        arguments.port if arguments.prefer_port is None else arguments.prefer_port,
        access.token,
        access.tls_cert,
        access.tls_key,
        arguments.read_only,
        tuple(arguments.allow),
        takes_any_port=arguments.prefer_port is not None,
        record_to=arguments.record_to,
        view=arguments.view,
        missions=arguments.missions,
    )


def _console(arguments: Namespace, output: Output) -> Outcome:
    settings = _settings(arguments)
    try:
        from goalwire.apps.console.server import serve
    except ModuleNotFoundError as error:
        raise CommandError(
            Outcome.NOT_FOUND,
            f"the console needs packages that are not installed, first of all '{error.name}'",
            "run: pip install 'goalwire[console]'",
        ) from None

    def ready(urls: list[str]) -> None:
        if output.json:
            output.data({'url': urls[0], 'urls': urls})
        else:
            _tell_where(urls, settings, output)
        output.flush()
        if not arguments.no_open:
            _open(urls[0])

    if arguments.bag is not None:
        return _show_bag(arguments.bag, settings, ready)

    async def run(node: goalwire.Node) -> None:
        await serve(node, settings, ready)

    return live(run, f'goalwire_console_{os.getpid()}')


def _show_bag(path: str, settings: Settings, ready: Callable[[list[str]], object]) -> Outcome:
    """Serve the page of a bag, without a node: so the page cannot send anything to a robot."""
    from goalwire.apps.console.server import serve_recording

    return until_signal(lambda: serve_recording(path, settings, ready))


def _tell_where(urls: list[str], settings: Settings, output: Output) -> None:
    from goalwire.apps.console.addresses import is_every_interface

    if settings.takes_any_port and settings.port != urlsplit(urls[0]).port:
        output.line(f'port {settings.port} is taken: the address is another one this time')
    output.line(f'the console is at {urls[0]}; Ctrl-C ends it')
    if is_asked_for():
        output.line('people sign in with tokens of their own: goalwire secure token NAME')
    for url in urls[1:]:
        output.line(f'from other machines it is at {url}')
    if is_every_interface(settings.host) and not urls[1:]:
        output.line('no other machine reaches it yet: no network interface has an address')
    if not settings.is_loopback and not settings.tls_cert:
        output.line(NOT_ENCRYPTED)


def _open(url: str) -> None:
    """Open the user's browser, if there is one, on a thread: starting some browsers blocks."""
    import webbrowser
    from threading import Thread

    Thread(target=webbrowser.open, args=(url,), daemon=True, name='console-browser').start()


_SUMMARY = 'Show the robot in the browser, and operate it there'
NOUN = Noun('console', _SUMMARY, (Verb('console', _SUMMARY, _console, _arguments),))
