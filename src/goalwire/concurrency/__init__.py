"""Threads beside each other: critical sections, ordered delivery, waiting on a wire, forks and exits.

Each session that has sockets of its own is built on this, whatever it speaks.
"""
