"""Launch files: goalwire's implementation of ROS 2's `launch` and `launch_ros`, on asyncio.

`model` has the base classes and says how a description is carried out, `service` the loop, `process` the
processes; `sources`, `frontend` and `notation` read files. The overlay's packages `launch`, `launch_ros`,
`launch_xml` and `launch_yaml` offer these classes under the names that launch files import.
"""
