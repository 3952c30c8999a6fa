"""ROS 2's commands that goalwire does not have: why, and the commands to use instead."""

from __future__ import annotations

ALIASES = {'wtf': 'doctor'}
"""ROS 2's other names of nouns."""

NOUNS = {
    'daemon': 'no daemon is needed here: each command looks at the graph itself, so there is nothing to stop',
    'extensions': 'these commands have no extensions',
    'extension_points': 'these commands have no extensions',
    'multicast': "use 'ros2 doctor', which sees whether others can be reached",
    'plugin': "use 'ros2 component types' for components; C++ plugins are not loaded here",
    'security': 'encrypted links are set up in the configuration of Zenoh, see docs/how-to/real-robot.md',
    'test': "use 'pytest', for launch tests too",
    'trace': "use 'goalwire top' or the statistics of entities, see docs/how-to/statistics.md",
}
VERBS = {
    ('pkg', 'create'): "use 'goalwire new';",
    ('node', 'kill'): 'end its process: Ctrl-C, or kill with its process id;',
}
HARMLESS = {('daemon', 'start'), ('daemon', 'status'), ('daemon', 'stop')}
"""Commands about the daemon that scripts call: each succeeds, and says that there is nothing to do."""
