"""ros2 bag: its verbs. The module of a verb is imported when the verb runs."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'bag',
    'Various rosbag related commands',
    (
        Verb('burst', 'Burst data from a bag', *lazy('bag.play', 'burst'), has_json=False),
        Verb(
            'check',
            'Read every byte of a bag, and say what is wrong with it',
            *lazy('bag.mending', 'check_bag'),
            has_json=False,
        ),
        Verb(
            'convert',
            'Given an input bag, write out a new bag with different settings',
            *lazy('bag.convert'),
            has_json=False,
        ),
        Verb(
            'export',
            'Write bags as CSV, JSON lines, Parquet, pictures or a dataset of LeRobot',
            *lazy('bag.export'),
            has_json=False,
        ),
        Verb('info', 'Print information about a bag to the screen', *lazy('bag.looking', 'show_info')),
        Verb(
            'list',
            'Print information about available plugins to the screen',
            *lazy('bag.looking', 'list_plugins'),
        ),
        Verb('play', 'Play back ROS data from a bag', *lazy('bag.play'), has_json=False),
        Verb('record', 'Record ROS data to a bag', *lazy('bag.record'), has_json=False),
        Verb(
            'reindex',
            'Reconstruct metadata file for a bag',
            *lazy('bag.mending', 'reindex_bag'),
            has_json=False,
        ),
        Verb(
            'repair',
            'Write whatever can be read of a bag into a new one',
            *lazy('bag.mending', 'repair_bag'),
            has_json=False,
        ),
    ),
)
