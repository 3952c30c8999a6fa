"""ros2 bag burst: publish messages as fast as can be, then pause."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from goalwire.apps.bag.options import PlayOptions
from goalwire.apps.cli.commands.bag.choosing import bag_argument, open_bag
from goalwire.apps.cli.commands.bag.play import NODE_NAME, add_choice, overrides, selection
from goalwire.apps.cli.framework.numbers import length
from goalwire.apps.cli.framework.output import tell

if TYPE_CHECKING:
    import goalwire
    from goalwire.apps.cli.framework.outcome import Outcome
    from goalwire.apps.cli.framework.output import Output


def add_arguments(parser: ArgumentParser) -> None:
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


def run(arguments: Namespace, output: Output) -> Outcome:  # noqa: ARG001 - it prints no data
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

        async def burst(node: goalwire.Node) -> None:
            player = Player(node, bag, options)
            offer_services(player)
            player.step(arguments.num_messages or bag.facts.count)
            tell(f"bursting '{bag.path}'; Ctrl-C ends it")
            await player.play()
            tell(f'{player.published:,} messages were published')

        return live(burst, NODE_NAME)
