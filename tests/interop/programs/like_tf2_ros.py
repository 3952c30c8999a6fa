"""As tf2_ros: a buffer server, and a client that asks it by the action client's own names."""

import threading

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.action import ActionServer
from rclpy.action.client import ActionClient
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor
from rclpy.time import Time
from tf2_msgs.action import LookupTransform
from tf2_msgs.msg import TF2Error
from tf2_ros import Buffer, BufferClient, LookupException, StaticTransformBroadcaster, TransformListener


def serve(buffer):
    def execute(handle):
        goal, result = handle.request, LookupTransform.Result()
        try:
            result.transform = buffer.lookup_transform(
                goal.target_frame,
                goal.source_frame,
                Time.from_msg(goal.source_time),
                Duration.from_msg(goal.timeout),
            )
        except LookupException as error:
            result.error = TF2Error(error=TF2Error.LOOKUP_ERROR, error_string=str(error))
        handle.succeed()
        return result

    return execute


def asked_as_tf2_ros_does(node):
    client = ActionClient(node, LookupTransform, action_name='tf2_buffer_server')
    assert client.wait_for_server(10.0)
    goal = LookupTransform.Goal(target_frame='map', source_frame='lamp', timeout=Duration(seconds=5).to_msg())
    event = threading.Event()
    sent = client.send_goal_async(goal)
    sent.add_done_callback(lambda _: event.set())
    assert event.wait(10)
    assert sent.result().accepted
    response = client._get_result(sent.result())
    assert response.result.error.error == TF2Error.NO_ERROR
    return response.result.transform.transform.translation.x


def main():
    rclpy.init()
    server, asker = rclpy.create_node('server'), rclpy.create_node('asker')
    buffer = Buffer(node=server)
    TransformListener(buffer, server)
    ActionServer(server, LookupTransform, 'tf2_buffer_server', serve(buffer))
    executor = MultiThreadedExecutor(8)
    executor.add_node(server)
    executor.add_node(asker)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    told = TransformStamped(child_frame_id='lamp')
    told.header.frame_id = 'map'
    told.transform.translation.x = 2.0
    told.transform.rotation.w = 1.0
    StaticTransformBroadcaster(asker).sendTransform(told)

    print('by the action', asked_as_tf2_ros_does(asker))
    client = BufferClient(
        asker, 'tf2_buffer_server', check_frequency=10.0, timeout_padding=Duration(seconds=2.0)
    )
    assert client.action_client.wait_for_server(10.0)
    found = client.lookup_transform('map', 'lamp', Time(), Duration(seconds=5))
    print('by the client', found.transform.translation.x)
    try:
        client.lookup_transform('map', 'nowhere', Time())
    except LookupException as error:
        print('refused', 'nowhere' in str(error))
    client.destroy()
    print('latest', buffer.get_latest_common_time('map', 'lamp') == Time())
    executor.shutdown(wait_for_threads=True)
    thread.join()
    rclpy.shutdown()


main()
