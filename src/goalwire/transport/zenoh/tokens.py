"""Liveliness tokens: how nodes and endpoints show themselves, and what their gids are made of.

    node      @ros2_lv/<domain>/<session>/<node id>/<node id>/NN/<enclave>/<namespace>/<name>
    endpoint  @ros2_lv/<domain>/<session>/<node id>/<id>/<MP|MS|SS|SC>/<enclave>/<namespace>/<name>
              /<topic or service>/<dds type>/<hash>/<qos>[/<backends>]

Slashes within a chunk are written as '%'. Source: rmw_zenoh_cpp src/detail/liveliness_utils.cpp.
"""

from __future__ import annotations

from functools import lru_cache

from xxhash import xxh3_128_intdigest

from goalwire.errors import RemoteError, TransportError
from goalwire.transport.contract import Endpoint, EndpointKind, GraphEntity, NodeName
from goalwire.transport.reports import check_names
from goalwire.transport.zenoh.keyexpr import GRAPH_SPACE, dds_type, ros_type
from goalwire.transport.zenoh.qos_text import decimal, decode_qos, encode_qos

_CODES = {
    EndpointKind.NODE: 'NN',
    EndpointKind.PUBLISHER: 'MP',
    EndpointKind.SUBSCRIPTION: 'MS',
    EndpointKind.SERVICE: 'SS',
    EndpointKind.CLIENT: 'SC',
}
_KINDS = {code: kind for kind, code in _CODES.items()}
_NODE_CHUNKS = 9
_ENDPOINT_CHUNKS = 13
_CPU_ONLY = 'backends:cpu:'


def encode_node(domain_id: int, session: str, node_id: int, node: NodeName) -> str:
    """Return a node's token; a node is its own entity, so its id stands twice."""
    return _head(domain_id, session, node_id, node_id, EndpointKind.NODE, node)


def encode_endpoint(
    domain_id: int, session: str, node_id: int, entity_id: int, node: NodeName, endpoint: Endpoint
) -> str:
    """Return an endpoint's token; raises LocalError for a QoS that no endpoint can have."""
    chunks = [
        _head(domain_id, session, node_id, entity_id, endpoint.kind, node),
        _mangle(endpoint.name),
        dds_type(endpoint.type_name),
        endpoint.type_hash,
        encode_qos(endpoint.qos),
    ]
    if uses_cpu_channel(endpoint):
        chunks.append(_CPU_ONLY)
    return '/'.join(chunks)


def uses_cpu_channel(endpoint: Endpoint) -> bool:
    """True for a subscription that must say it takes plain memory, or lyrical's publishers miss it."""
    return (
        endpoint.kind is EndpointKind.SUBSCRIPTION
        and endpoint.has_buffers
        and not endpoint.qos.is_transient_local
    )


def _head(
    domain_id: int, session: str, node_id: int, entity_id: int, kind: EndpointKind, node: NodeName
) -> str:
    return f'{GRAPH_SPACE}/{domain_id}/{session}/{node_id}/{entity_id}/{_CODES[kind]}/{_names(node)}'


@lru_cache(maxsize=64)  # asked for once for each endpoint of a node
def _names(node: NodeName) -> str:
    names = '/'.join(_mangle(text) for text in (node.enclave or '/', node.namespace or '/', node.name))
    if not _is_carried(names):
        raise TransportError(
            f"node '{node.qualified}' (enclave '{node.enclave}') has a name Zenoh cannot carry"
        )
    return names


def _mangle(text: str) -> str:
    return text.replace('/', '%')


def _demangle(text: str) -> str:
    return text.replace('%', '/')


def _is_carried(key: str) -> bool:
    return '//' not in key and not key.endswith('/') and not any(sign in key for sign in '*#?$')


def gid_of(token: str) -> bytes:
    """Return the 16 bytes that name a token's owner: XXH3-128 of the token, little endian.

    Of an endpoint's, the chunks that Jazzy knows: it leaves `backends` out. Lyrical does not, but there is
    nothing that a subscription's gid must agree with.
    """
    chunks = token.split('/', _ENDPOINT_CHUNKS)
    if len(chunks) > _ENDPOINT_CHUNKS:
        token = '/'.join(chunks[:_ENDPOINT_CHUNKS])
    return xxh3_128_intdigest(token.encode()).to_bytes(16, 'little')


def own_entity(token: str, session: str, node_id: int, node: NodeName, endpoint: Endpoint) -> GraphEntity:
    """Return what `parse` makes of the token of an endpoint of ours."""
    return GraphEntity(
        endpoint.kind,
        session,
        node_id,
        node,
        name=endpoint.name,
        type_name=endpoint.type_name,
        type_hash=endpoint.type_hash,
        qos=decode_qos(encode_qos(endpoint.qos)),
        gid=gid_of(token),
    )


def parse(token: str) -> GraphEntity:
    """Read a token; raises RemoteError, naming the chunk, for one that breaks the grammar."""
    chunks = token.split('/')
    check_names('liveliness token', *chunks)
    if len(chunks) < _NODE_CHUNKS or chunks[0] != GRAPH_SPACE or '' in chunks:
        raise RemoteError(f"liveliness token '{token}': expected {_NODE_CHUNKS} or more chunks, none empty")
    _, domain, session, node_id, entity_id, code, enclave, namespace, name = chunks[:_NODE_CHUNKS]
    try:
        _, node_number, _ = map(decimal, (domain, node_id, entity_id))
    except ValueError as error:
        raise RemoteError(f"liveliness token '{token}': {error}") from None
    kind = _KINDS.get(code)
    if kind is None:
        raise RemoteError(f"liveliness token '{token}': '{code}' is none of {', '.join(_KINDS)}")
    node = NodeName(_demangle(name), _demangle(namespace), _demangle(enclave))
    if kind is EndpointKind.NODE:
        return GraphEntity(kind, session, node_number, node, gid=gid_of(token))
    if len(chunks) < _ENDPOINT_CHUNKS:
        raise RemoteError(f"liveliness token '{token}': an endpoint's has {_ENDPOINT_CHUNKS} chunks or more")
    topic, type_text, type_hash, qos = chunks[_NODE_CHUNKS:_ENDPOINT_CHUNKS]
    return GraphEntity(
        kind,
        session,
        node_number,
        node,
        name=_demangle(topic),
        type_name=ros_type(_demangle(type_text)),
        type_hash=_demangle(type_hash),
        qos=decode_qos(qos),
        gid=gid_of(token),
    )
