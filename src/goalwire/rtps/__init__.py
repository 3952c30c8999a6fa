"""DDSI-RTPS, the protocol of DDS: a separate library that knows nothing of ROS.

protocol    the protocol as pure code: bytes and times go in, bytes and calls come out
"""
