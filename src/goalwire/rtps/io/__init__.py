"""Sockets and waiting for `rtps.protocol`.

interfaces      the addresses of this host
addresses       which ports a participant has, and where it announces itself
sockets         the UDP sockets of a participant
session         a participant with its sockets, and who waits on them
"""
