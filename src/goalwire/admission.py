"""Decides which browsers and clients may talk to a server on this machine: the console and the bridges.

A page on another site can make a browser open web sockets here, which know no same-origin policy. By a name
of its own that it points at this machine (DNS rebinding) it makes its requests look like those of this site.
So a server without a token answers only to requests that name this machine.
"""

from __future__ import annotations

import hmac
import secrets
from ipaddress import ip_address
from urllib.parse import urlsplit


def is_loopback(host: str) -> bool:
    """Return whether a host's name or address means only this machine."""
    if host == 'localhost':
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


def host_name(host: str) -> str:
    """Return the name in 'name:port' or '[::1]:port', as the header `Host` has it; '' if there is none."""
    try:
        return urlsplit(f'//{host}').hostname or ''
    except ValueError:
        return ''


def is_of_this_machine(origin: str) -> bool:
    """Return whether an `Origin` such as 'http://localhost:8000' is a page that this machine serves."""
    try:
        return is_loopback(urlsplit(origin).hostname or '')
    except ValueError:
        return False


def new_token() -> str:
    """Return a token that nobody guesses."""
    return secrets.token_urlsafe(24)


def is_same_token(shown: str, token: str) -> bool:
    """Compare in a time that tells nothing about the token."""
    return hmac.compare_digest(shown.encode(), token.encode())


def is_usable_token(token: str) -> bool:
    """Return whether a token can stand in an address and in a cookie as it is."""
    return all(each.isalnum() or each in '-_.~' for each in token)
