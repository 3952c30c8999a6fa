"""Complete configurations for programs of rmw_zenoh: its router and its sessions.

Those sessions check no policy. So they only connect to a router that does, and never to each other.
"""

from __future__ import annotations

from goalwire.security.environment import Chosen
from goalwire.security.policy_file import load_policy
from goalwire.security.revocation import load_revocations
from goalwire.transport.zenoh.router_rules import access_control
from goalwire.transport.zenoh.settings import built_in
from goalwire.transport.zenoh.settings.values import Configuration, Settings


def rules_of(identity: Chosen) -> Settings:
    """Return the access control that a keystore's policy requires. Raises SecurityError."""
    policy = load_policy(identity.folder / 'policy.toml')
    return access_control(policy, load_revocations(identity.folder / 'revoked.toml'))


def router_settings(identity: Chosen, port: int) -> Settings:
    """Return the settings of a router that enforces the policy. Raises SecurityError."""
    config = Configuration(built_in.rendezvous(port))
    config.set('listen/endpoints', built_in.everywhere(port))
    config.set('transport/link/tls', built_in.tls_of_identity(identity))
    config.set('transport/link/tls/close_link_on_expiration', True)
    config.set('access_control', rules_of(identity))
    return config.values


def session_settings(identity: Chosen, router: str) -> Settings:
    """Return the settings of a session that talks only through a router."""
    config = Configuration(built_in.session(0))
    config.set('mode', 'client')
    config.set('connect/endpoints', [router])
    config.set('listen/endpoints', [])
    config.set('transport/link/tls', built_in.tls_of_identity(identity))
    return config.values
