"""Decides which browsers and clients may talk to a server on this machine: the console and the bridges.

A page of another site can make a browser open web sockets to this machine, since browsers apply no
same-origin policy to web sockets. If the page's site points its own host name at this machine (DNS
rebinding), the requests look like those of this server's own page. So a server without a token answers only
to requests that name this machine.
"""

from __future__ import annotations

import hmac
import secrets
from ipaddress import ip_address
from urllib.parse import urlsplit


def is_loopback(host: str) -> bool:
    """Return whether a host's name or address is a loopback one, which means this machine."""
    if host == 'localhost':
        return True
    try:
        return ip_address(host).is_loopback
    except ValueError:
        return False


def host_name(host: str) -> str:
    """Return the host's name in the value of a header `Host`, such as 'name:port' or '[::1]:port'; '' without
    one.
    """
    try:
        return urlsplit(f'//{host}').hostname or ''
    except ValueError:
        return ''


def is_of_this_machine(origin: str) -> bool:
    """Return whether an `Origin` such as 'http://localhost:8000' belongs to a page that this
    machine serves.
    """
    try:
        return is_loopback(urlsplit(origin).hostname or '')
    except ValueError:
        return False


def new_token() -> str:
    """Return a new random token that nobody can guess."""
    return secrets.token_urlsafe(24)


def is_same_token(shown: str, token: str) -> bool:
    """Compare two tokens in a time that reveals nothing about the right token."""
    return hmac.compare_digest(shown.encode(), token.encode())


def is_usable_token(token: str) -> bool:
    """Return whether a token can be put into a URL and a cookie without escaping."""
    return all(each.isalnum() or each in '-_.~' for each in token)
