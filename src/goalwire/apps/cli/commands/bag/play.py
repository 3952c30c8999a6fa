"""ros2 bag play and burst: publish the messages of a bag."""

from __future__ import annotations

import asyncio
from argparse import ArgumentParser, ArgumentTypeError, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.bag.options import PlayOptions
from goalwire.apps.bag.selection import Names, Selection
from goalwire.apps.cli.commands.bag.choosing import (
    add_name_arguments,
    add_regex_arguments,
    bag_argument,
    names,
    open_bag,
)
from goalwire.apps.cli.commands.bag.keys import keys
from goalwire.apps.cli.commands.bag.live_servers import add_live_arguments, answer, expect
from goalwire.apps.cli.framework.lookup import full_name
from goalwire.apps.cli.framework.numbers import length, positive, seconds
from goalwire.apps.cli.framework.outcome import Outcome
from goalwire.apps.cli.framework.output import tell
from goalwire.apps.programs.keyboard import DOWN, RIGHT, UP

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.bag.player import Player
    from goalwire.apps.cli.framework.output import Output
    from goalwire.rosbag2.reader import Reader


NODE_NAME = 'rosbag2_player'
CLOCK_HZ = 40.0
_FASTER = 1.1
_PROGRESS_S = 0.2
_HELP = 'space: pause, right: next message, up and down: faster and slower'


def add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag play`."""
    bag_argument(parser)
    add_choice(parser)
    parser.add_argument(
        '-r',
        '--rate',
        metavar='N',
        type=positive,
        default=1.0,
        help='Play N times as fast as recorded (default: 1)',
    )
    parser.add_argument('-l', '--loop', action='store_true', help='Begin again at the end')
    parser.add_argument(
        '-d', '--delay', metavar='S', type=positive, default=0.0, help='Wait S seconds before each round'
    )
    parser.add_argument(
        '--playback-duration', metavar='S', type=seconds, default=-1.0, help='Play for S seconds'
    )
    until = parser.add_mutually_exclusive_group()
    until.add_argument(
        '--playback-until-sec', metavar='S', type=seconds, default=-1.0, help='Play up to this time'
    )
    until.add_argument(
        '--playback-until-nsec', metavar='NS', type=int, default=-1, help='The same in nanoseconds'
    )
    _add_clock(parser)
    parser.add_argument('-p', '--start-paused', action='store_true', help='Begin paused')
    parser.add_argument(
        '--wait-for-all-acked',
        metavar='MS',
        type=length,
        help='Wait at the end for reliable subscriptions (0: for ever)',
    )
    parser.add_argument('--disable-keyboard-controls', action='store_true', help=f'Read no keys ({_HELP})')
    parser.add_argument(
        '--publish-service-requests', action='store_true', help='Send the recorded requests to the servers'
    )
    parser.add_argument(
        '--service-requests-source',
        choices=('service_introspection', 'client_introspection'),
        default='service_introspection',
        help='The side whose recorded events give the requests and goals (default: the servers)',
    )
    parser.add_argument(
        '--send-actions-as-client',
        action='store_true',
        help='Send the recorded goals to the action servers, and cancel those that were cancelled',
    )
    add_live_arguments(parser)
    parser.add_argument('--disable-loan-message', action='store_true', help='Accepted as in ROS 2')


def _add_clock(parser: ArgumentParser) -> None:
    clock = parser.add_mutually_exclusive_group()
    clock.add_argument(
        '--clock',
        metavar='HZ',
        type=positive,
        nargs='?',
        const=CLOCK_HZ,
        default=0.0,
        help=f'Publish the time of the bag on /clock (default: {CLOCK_HZ:g} times a second)',
    )
    clock.add_argument(
        '--clock-topics', metavar='TOPIC', nargs='+', default=[], help='… before messages of these topics'
    )
    clock.add_argument('--clock-topics-all', action='store_true', help='… before every message')


def add_choice(parser: ArgumentParser) -> None:
    """Add the arguments that `play` and `burst` share."""
    add_name_arguments(parser, 'Play')
    add_regex_arguments(parser, 'Play')
    parser.add_argument(
        '-m', '--remap', metavar='OLD:=NEW', nargs='+', type=_remap, default=[], help='Other names for topics'
    )
    parser.add_argument(
        '--start-offset',
        metavar='S',
        type=seconds,
        default=0.0,
        help='Begin S seconds after the start of the bag',
    )
    parser.add_argument(
        '--qos-profile-overrides-path', metavar='FILE', help='YAML: the QoS to publish with, by topic'
    )
    parser.add_argument('--read-ahead-queue-size', metavar='N', type=length, help='Accepted as in ROS 2')
    parser.add_argument('--storage-config-file', metavar='FILE', help='Accepted as in ROS 2')


def _remap(text: str) -> tuple[str, str]:
    old, found, new = text.partition(':=')
    if not found:
        raise ArgumentTypeError(f"'{text}' is not of the form OLD:=NEW")
    return full_name(old, 'topic'), full_name(new, 'topic')


def selection(arguments: Namespace) -> Selection:
    """Return the chosen topics, services and actions; everything if none is named."""
    kinds = {}
    for kind in ('topic', 'service', 'action'):
        some = names(getattr(arguments, f'{kind}s'), kind)
        kinds[kind] = Names(some=some, out=names(getattr(arguments, f'exclude_{kind}s'), kind))
    if not arguments.regex and not any(each.some for each in kinds.values()):
        kinds = {kind: Names(all=True, out=each.out) for kind, each in kinds.items()}
    return Selection(
        kinds['topic'],
        kinds['service'],
        kinds['action'],
        regex=arguments.regex,
        regex_out=arguments.exclude_regex,
        hidden=True,
    )


def overrides(path: str | None) -> tuple[tuple[str, goalwire.QoS], ...]:
    """Return the QoS that a file sets, by topic."""
    if path is None:
        return ()
    from goalwire.apps.bag.qos_overrides import read_qos_overrides

    return tuple(read_qos_overrides(path).items())


def _options(arguments: Namespace) -> PlayOptions:
    until = arguments.playback_until_nsec if arguments.playback_until_nsec >= 0 else None
    if arguments.playback_until_sec >= 0:
        until = int(arguments.playback_until_sec * 1e9)
    return PlayOptions(
        selection=selection(arguments),
        rate=arguments.rate,
        start_offset=arguments.start_offset,
        duration=arguments.playback_duration if arguments.playback_duration >= 0 else None,
        until=until,
        loop=arguments.loop,
        delay=arguments.delay,
        remaps=tuple(arguments.remap),
        qos=overrides(arguments.qos_profile_overrides_path),
        clock_hz=arguments.clock,
        clock_topics=names(arguments.clock_topics, 'topic'),
        clock_always=arguments.clock_topics_all,
        paused=arguments.start_paused,
        requests_from=arguments.service_requests_source if arguments.publish_service_requests else '',
        goals_from=arguments.service_requests_source if arguments.send_actions_as_client else '',
    )


def run(arguments: Namespace, output: Output) -> Outcome:
    """Play the bag to its end, or until Ctrl-C."""
    options = _options(arguments)
    with open_bag(arguments) as bag:
        if arguments.expect:
            return expect(bag, selection(arguments), arguments, output)
        if arguments.answer_calls:
            return answer(bag, selection(arguments), arguments)
        return play(bag, options, arguments, output)


def play(bag: Reader, options: PlayOptions, arguments: Namespace, output: Output) -> Outcome:
    """Play a bag with a node of the command's own."""
    from goalwire.apps.bag.player import Player
    from goalwire.apps.bag.player_services import offer_services
    from goalwire.apps.cli.framework.live import live

    async def run_player(node: goalwire.Node) -> None:
        player = Player(node, bag, options)
        offer_services(player)
        for problem in bag.problems:
            tell(f'{problem}; what is there is played')
        tell(f"playing '{bag.path}': {len(player.topics)} topics{', paused' if player.paused else ''}")
        await _steered(player, arguments, output)
        acked: int | None = getattr(arguments, 'wait_for_all_acked', None)
        if acked is not None:
            await asyncio.to_thread(player.wait_for_acknowledgements, acked * 1_000_000 or None)
        requests = f', {player.requested:,} requests were sent' if options.requests_from else ''
        goals = f', {player.goals_sent:,} goals were sent' if options.goals_from else ''
        tell(f'{player.published:,} messages were published{requests}{goals}')

    return live(run_player, NODE_NAME)


async def _steered(player: Player, arguments: Namespace, output: Output) -> None:
    """Play while keys on the terminal control the player; the terminal shows the position."""
    if getattr(arguments, 'disable_keyboard_controls', True):
        await player.play()
        return
    with keys(lambda key: press(player, key)) as has_keys:
        if has_keys:
            tell(_HELP)
        showing = asyncio.create_task(_show(player, output)) if output.is_terminal else None
        try:
            await player.play()
        finally:
            if showing is not None:
                showing.cancel()
                output.rewrite('')


def press(player: Player, key: str) -> None:
    """Carry out the player command that a pressed key stands for."""
    if key == ' ':
        player.resume() if player.paused else player.pause()
    elif key == RIGHT:
        player.step()
    elif key in {UP, DOWN}:
        player.rate *= _FASTER if key == UP else 1 / _FASTER


async def _show(player: Player, output: Output) -> None:
    length_ns = max(player.end - player.start, 1)
    while True:
        passed = player.position - player.start
        bar = '━' * (30 * passed // length_ns)
        state = 'paused' if player.paused else f'x{player.rate:.2g}'
        output.rewrite(f'{bar:30} {passed / 1e9:.1f} of {length_ns / 1e9:.1f} s, {state}')
        await asyncio.sleep(_PROGRESS_S)


def add_burst_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `bag burst`."""
    bag_argument(parser)
    add_choice(parser)
    parser.add_argument(
        '-n',
        '--num-messages',
        metavar='N',
        type=length,
        default=0,
        help='Publish N messages, then pause (0: all)',
    )


def burst(arguments: Namespace, _output: Output) -> Outcome:
    """Publish the burst; then the services of the player's node control the playing, until Ctrl-C."""
    from goalwire.apps.bag.player import Player
    from goalwire.apps.bag.player_services import offer_services
    from goalwire.apps.cli.framework.live import live

    options = PlayOptions(
        selection=selection(arguments),
        start_offset=arguments.start_offset,
        remaps=tuple(arguments.remap),
        qos=overrides(arguments.qos_profile_overrides_path),
        paused=True,
    )
    with open_bag(arguments) as bag:

        async def run_player(node: goalwire.Node) -> None:
            player = Player(node, bag, options)
            offer_services(player)
            player.step(arguments.num_messages or bag.facts.count)
            tell(f"bursting '{bag.path}'; Ctrl-C ends it")
            await player.play()
            tell(f'{player.published:,} messages were published')

        return live(run_player, NODE_NAME)
