"""Sockets and waiting for `rtps.protocol`.

settings            the values that a session is opened with
interface_changes   notices when interfaces change
addresses           the ports of a participant, and the addresses to which it announces itself
sockets             the UDP sockets of a participant
session             a participant with its sockets, read by the threads that wait on them
"""
