"""DDSI-RTPS, the protocol of DDS: a separate library that knows nothing of ROS.

protocol the protocol as pure code: it gets bytes and times, and returns bytes and makes calls
"""
