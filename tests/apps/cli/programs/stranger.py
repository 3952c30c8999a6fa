"""A node whose types are known in this program alone."""

import rclpy
from away_interfaces.action import Sweep
from away_interfaces.msg import Gauge, Stamped
from away_interfaces.srv import Tune
from rclpy.action import ActionServer
from rclpy.node import Node

with rclpy.init():
    node = Node('stranger')
    publisher = node.create_publisher(Gauge, 'gauge', 10)
    gauge = Gauge(name='oil')
    gauge.needle.angle = 0.5
    stamped_publisher = node.create_publisher(Stamped, 'stamped', 10)
    stamped = Stamped(value=1.0)

    def publish():
        publisher.publish(gauge)
        stamped.header.stamp = node.get_clock().now().to_msg()
        stamped_publisher.publish(stamped)

    node.create_timer(0.1, publish)

    def tune(request, response):
        response.reached = request.wanted * 2
        return response

    def sweep(goal_handle):
        goal_handle.publish_feedback(Sweep.Feedback(part=0.5))
        goal_handle.succeed()
        return Sweep.Result(sweeps=goal_handle.request.sweeps)

    node.create_service(Tune, 'tune', tune)
    server = ActionServer(node, Sweep, 'sweep', sweep)
    print('ready')
    rclpy.spin(node)
