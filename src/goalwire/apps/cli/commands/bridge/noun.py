"""goalwire bridge: serves programs that use web sockets instead of ROS 2."""

from __future__ import annotations

from goalwire.apps.cli.framework.verbs import Noun, Verb, lazy

NOUN = Noun(
    'bridge',
    'Serve topics, services and actions to web sockets',
    (
        Verb(
            'foxglove',
            'Serve Foxglove and clients of its protocol',
            *lazy('bridge.serving', 'serve_foxglove'),
        ),
        Verb(
            'rosbridge',
            'Serve clients of rosbridge, such as roslibjs and roslibpy',
            *lazy('bridge.serving', 'serve_rosbridge'),
        ),
    ),
)
