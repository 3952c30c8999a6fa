"""The names under which a robot that can fall tells and asks."""

from __future__ import annotations

FALLEN = 'fallen'  # std_msgs/Bool, latched
BALANCING = 'balancing_joints'  # std_msgs/String, latched: their names, with commas between
GET_UP = 'get_up'  # std_srvs/Trigger
PUSH = 'push'  # humanoid_interfaces/Push, of the simulation only
LIES = 'the robot has fallen; humanoid get_up puts it back on its feet'
FELL = 'The robot has fallen'
BALANCES = 'keeps the robot on its feet and takes no commands'
