"""Parameters from a file: declared with a range, watched while the program runs.

python examples/parameters_from_file.py --ros-args --params-file examples/cruise.yaml
"""

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor, SetParametersResult
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.parameter import Parameter


class Cruise(Node):
    def __init__(self):
        super().__init__('cruise')
        limits = FloatingPointRange(from_value=0.0, to_value=2.0)
        self.declare_parameter(
            'speed', 0.5, ParameterDescriptor(description='m/s', floating_point_range=[limits])
        )
        self.declare_parameter('route', ['home'])
        self.declare_parameter('wheels.radius', 0.1)
        self.add_on_set_parameters_callback(self.judge)
        self.create_timer(0.2, self.drive)

    def judge(self, parameters):
        for parameter in parameters:
            if parameter.name == 'wheels.radius':
                return SetParametersResult(successful=False, reason='nobody changes wheels while driving')
        return SetParametersResult(successful=True)

    def drive(self):
        speed, route = (parameter.value for parameter in self.get_parameters(['speed', 'route']))
        turns = speed / (6.283 * self.get_parameter('wheels.radius').value)
        self.get_logger().info(f'To {route[0]} at {speed} m/s, {turns:.2f} turns a second')
        self.try_to_set('speed', speed + 0.5)
        self.try_to_set('wheels.radius', 0.2)

    def try_to_set(self, name, value):
        [result] = self.set_parameters([Parameter(name, value=value)])
        if not result.successful:
            self.get_logger().warning(f'{name} stays as it is: {result.reason}')


def main():
    rclpy.init()
    try:
        rclpy.spin(Cruise())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == '__main__':
    main()
