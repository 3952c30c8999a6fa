"""The topics and services of a robot that can fall."""

from __future__ import annotations

FALLEN = 'fallen'  # std_msgs/Bool, latched
BALANCING = 'balancing_joints'  # std_msgs/String, latched: the balancing joints' names, separated by commas
GET_UP = 'get_up'  # std_srvs/Trigger
PUSH = 'push'  # humanoid_interfaces/Push, served by the simulation only
LIES = 'the robot has fallen; humanoid get_up puts it back on its feet'
FELL = 'The robot has fallen'
BALANCES = 'keeps the robot on its feet and takes no commands'
