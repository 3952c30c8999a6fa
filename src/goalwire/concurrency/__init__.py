"""Tools for threads: critical sections, ordered delivery, waiting on sockets, forks and exits.

Each session that has sockets of its own is built on them, whatever its protocol.
"""
