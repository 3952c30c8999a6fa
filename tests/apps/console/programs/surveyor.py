"""Publishes what layers show: a map with one wall, a scan, points, markers and a path, in the frame `map`.

`map` lies at (-1, 0) in the frame `world`, and the robot's `odom` in `world`, too.
"""

import asyncio

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped, TransformStamped
from nav_msgs.msg import OccupancyGrid, Path
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2
from sensor_msgs_py.point_cloud2 import create_cloud_xyz32
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

import goalwire

LATCHED = goalwire.QoS(depth=1, durability=goalwire.DurabilityPolicy.TRANSIENT_LOCAL)
SIDE = 20  # cells of 0.2 m


def at(parent, child, x):
    frame = TransformStamped()
    frame.header.frame_id, frame.child_frame_id = parent, child
    frame.transform.translation.x = x
    return frame


def grid():
    message = OccupancyGrid()
    message.header.frame_id = 'map'
    message.info.width = message.info.height = SIDE
    message.info.resolution = 0.2
    message.info.origin.position.y = -2.0
    message.data = [100 if column == 8 and row >= 12 else 0 for row in range(SIDE) for column in range(SIDE)]
    return message


def marker(number, kind, x, **more):
    message = Marker(ns='things', id=number, type=kind, **more)
    message.header.frame_id = 'map'
    message.pose.position.x, message.pose.position.z = x, 0.5
    message.scale.x = message.scale.y = message.scale.z = 0.4
    message.color.g = message.color.a = 1.0
    return message


def path():
    message = Path()
    message.header.frame_id = 'map'
    for x in (1.0, 2.0):
        pose = PoseStamped()
        pose.pose.position.x, pose.pose.position.y = x, -1.0
        message.poses.append(pose)
    return message


def seen_by_the_camera():
    calibration = [100.0, 0.0, 80.0, 0.0, 100.0, 60.0, 0.0, 0.0, 1.0]
    message = CameraInfo(width=160, height=120, k=calibration)
    message.header.frame_id = 'map'
    return message


def somewhere():
    message = PoseWithCovarianceStamped()
    message.header.frame_id = 'map'
    message.pose.pose.position.x = 1.0
    message.pose.covariance[0] = message.pose.covariance[7] = 0.04
    return message


async def main():
    async with goalwire.Node('surveyor') as node:
        node.publisher(TFMessage, 'tf_static', qos=LATCHED).publish(
            transforms=[at('world', 'map', -1.0), at('world', 'odom', 0.0)]
        )
        node.publisher(OccupancyGrid, 'map', qos=LATCHED).publish(grid())
        markers = node.publisher(MarkerArray, 'markers', qos=LATCHED)
        markers.publish(markers=[marker(0, Marker.CUBE, 2.0), marker(1, Marker.CYLINDER, 3.0)])
        node.publisher(Path, 'plan', qos=LATCHED).publish(path())
        cloud = create_cloud_xyz32(Header(frame_id='map'), [(2.0, 1.0, 0.5), (2.0, 1.0, 1.0)])
        node.publisher(PointCloud2, 'points', qos=LATCHED).publish(cloud)
        node.publisher(CameraInfo, 'camera_info', qos=LATCHED).publish(seen_by_the_camera())
        red = Image(height=2, width=4, encoding='rgb8', step=12, data=bytes([200, 0, 0]) * 8)
        for topic in ('image_raw', 'elsewhere/image_raw'):
            node.publisher(Image, topic, qos=LATCHED).publish(red)
        node.publisher(PoseWithCovarianceStamped, 'amcl_pose', qos=LATCHED).publish(somewhere())
        scan = LaserScan(angle_increment=0.1, range_min=0.1, range_max=5.0, ranges=[2.0, 9.0])
        scan.header.frame_id = 'map'
        lost = LaserScan(range_max=5.0, ranges=[2.0])
        lost.header.frame_id = 'nowhere'
        scans, strays = node.publisher(LaserScan, 'scan'), node.publisher(LaserScan, 'stray_scan')
        print('ready', flush=True)
        async for _ in node.timer(0.1):
            scans.publish(scan)
            strays.publish(lost)


asyncio.run(main())
