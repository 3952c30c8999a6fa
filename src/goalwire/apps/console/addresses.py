"""The addresses at which browsers find a page that is served on all interfaces of this machine."""

from __future__ import annotations

from ipaddress import IPv4Address, IPv6Address, ip_address
from socket import has_dualstack_ipv6


def is_every_interface(host: str) -> bool:
    """Return True for 0.0.0.0, which means all interfaces by IPv4, and for ::, which adds IPv6."""
    try:
        return ip_address(host).is_unspecified
    except ValueError:
        return False


def addresses_on_networks(host: str) -> list[str]:
    """Return the addresses of this machine that others may reach if `host` is 0.0.0.0 or ::.

    Loopback and IPv6 link-local addresses are left out: browsers do not accept the zones of the latter.
    """
    import ifaddr  # a dependency of nicegui

    versions = {4} if ip_address(host).version == 4 else {4, 6} if has_dualstack_ipv6() else {6}
    found: list[str] = []
    for adapter in ifaddr.get_adapters():
        for each in adapter.ips:
            address = ip_address(each.ip if isinstance(each.ip, str) else each.ip[0])
            if address.version in versions and _is_for_others(address) and str(address) not in found:
                found.append(str(address))
    return found


def _is_for_others(address: IPv4Address | IPv6Address) -> bool:
    has_zone = address.version == 6 and address.is_link_local
    return not (address.is_loopback or address.is_unspecified or has_zone)
