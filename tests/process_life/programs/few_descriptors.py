"""With so many free descriptors as the argument says, a node is made, or refused with an error."""

from __future__ import annotations

import os
import resource
import sys

import rclpy
from rclpy.node import Node

free = int(sys.argv[1])
rclpy.init()
lowest = os.open('/dev/null', os.O_RDONLY)
os.close(lowest)
resource.setrlimit(resource.RLIMIT_NOFILE, (lowest + free, resource.getrlimit(resource.RLIMIT_NOFILE)[1]))
try:
    node = Node('few_descriptors')
    node.destroy_node()
    print('was made')
except Exception as error:
    print(f'was refused: {type(error).__name__}: {error}')
rclpy.shutdown()
print('good')
