"""Where data travels: `<domain>/<name>/<dds type>/<hash>`, one formula for topics and services.

Source: rmw_zenoh_cpp docs/design.md; the type spelling is that of ROS 2 over DDS.
"""

from __future__ import annotations

import re
from functools import lru_cache

from goalwire.errors import TransportError

GRAPH_SPACE = '@ros2_lv'
"""First chunk of every liveliness token; `@` keeps it out of the reach of `**` elsewhere."""
CPU_BUFFERS = '_buf_cpu'
"""Last chunk of the side channel that lyrical and later use for types with buffers (zenoh-wire A.9)."""

_FORBIDDEN = re.compile(r'//|[*#?$ ]')


@lru_cache(maxsize=256)
def dds_type(type_name: str) -> str:
    """Return 'std_msgs::msg::dds_::String_' for 'std_msgs/msg/String'."""
    *namespace, name = type_name.split('/')
    return '::'.join([*namespace, 'dds_', f'{name}_'])


@lru_cache(maxsize=256)
def ros_type(dds_name: str) -> str:
    """Return 'std_msgs/msg/String' for its DDS spelling; anything else comes back as it is."""
    namespace, found, name = dds_name.rpartition('::dds_::')
    if not found or not name.endswith('_'):
        return dds_name
    return f'{namespace.replace("::", "/")}/{name[:-1]}'


def data_key(domain_id: int, name: str, type_name: str, type_hash: str) -> str:
    """Return the key that publishers and subscriptions, or clients and servers, share.

    Raises TransportError for a name that Zenoh cannot carry.
    """
    path = name.removeprefix('/').removesuffix('/')
    key = f'{domain_id}/{path}/{dds_type(type_name)}/{type_hash}'
    if _FORBIDDEN.search(key):
        raise TransportError(
            f"'{name}' of type '{type_name}' (hash '{type_hash}') cannot travel over Zenoh: "
            f"empty parts and '*', '#', '?', '$' and blanks are not allowed; choose another name"
        )
    return key


def graph_key(domain_id: int) -> str:
    """Return the expression that matches every liveliness token of a domain."""
    return f'{GRAPH_SPACE}/{domain_id}/**'
