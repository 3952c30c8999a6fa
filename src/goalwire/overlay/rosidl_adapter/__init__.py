"""rosidl_adapter: only the parser of ROS 2's package, for tools that import it.

Goalwire does not convert definitions to IDL.
"""
