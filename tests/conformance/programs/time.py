"""Time, Duration and clocks: arithmetic, comparison, refusals, jumps, and the time that a node has."""

import rclpy
from builtin_interfaces.msg import Duration as DurationMessage
from builtin_interfaces.msg import Time as TimeMessage
from rclpy.clock import Clock, ClockChange, JumpThreshold, ROSClock, TimeJump
from rclpy.clock_type import ClockType
from rclpy.constants import S_TO_NS
from rclpy.duration import Duration, Infinite
from rclpy.node import Node
from rclpy.time import Time

ROS, SYSTEM, STEADY = ClockType.ROS_TIME, ClockType.SYSTEM_TIME, ClockType.STEADY_TIME

# -- Time

Time()
Time(seconds=1, nanoseconds=5)
str(Time(seconds=1))
Time(seconds=1.5).nanoseconds
Time(seconds=0.1).nanoseconds
Time(seconds=1.1).nanoseconds
Time(nanoseconds=1.9).nanoseconds
Time(seconds=1, nanoseconds=-1)
Time(nanoseconds=-1)
Time(seconds=-1)
Time(seconds='1')
Time(seconds=2**40)
Time(nanoseconds=2**63)
Time(nanoseconds=2**63 - 1).nanoseconds
Time(clock_type=1)
Time(clock_type='x')
Time(clock_type=ClockType.UNINITIALIZED)
Time(5)
Time(seconds=1, nanoseconds=2_500_000_000).seconds_nanoseconds()
Time(seconds=1).clock_type
Time(seconds=3, nanoseconds=4).to_msg()
Time(seconds=2**31).to_msg()
Time.from_msg(TimeMessage(sec=3, nanosec=4))
Time.from_msg(TimeMessage(sec=3, nanosec=4), clock_type=SYSTEM)
Time.from_msg(TimeMessage(sec=-3, nanosec=4))
Time.from_msg(DurationMessage(sec=3))
Time.from_msg(1)
hash(Time())
setattr(Time(), 'nanoseconds', 1)
Time(seconds=1) + Duration(seconds=1)
Duration(seconds=1) + Time(seconds=1)
Time(seconds=1) + Time(seconds=1)
Time(seconds=1) + 1
1 + Time()
Time(seconds=3) - Duration(seconds=1)
Time(seconds=1) - Duration(seconds=2)
Time(seconds=3) - Time(seconds=5)
Time(seconds=3) - 1
Time(seconds=3, clock_type=ROS) - Time(seconds=1, clock_type=SYSTEM)
Time(seconds=3, clock_type=ROS) + Duration(seconds=1)
Time(nanoseconds=2**63 - 1) + Duration(nanoseconds=1)
Time(seconds=1) + Duration(seconds=-2)
Time(seconds=1) == Time(nanoseconds=10**9)
Time(seconds=1) != Time(seconds=2)
Time(seconds=1) <= Time(seconds=2)
Time(seconds=1) > Time(seconds=2)
Time(seconds=1) == Time(seconds=1, clock_type=ROS)
Time(seconds=1) != Time(seconds=1, clock_type=ROS)
Time(seconds=1) < Time(seconds=1, clock_type=ROS)
Time(seconds=1) >= Time(seconds=1, clock_type=ROS)
Time(seconds=1) == 1
Time(seconds=1) == Duration(seconds=1)
Time(seconds=1) < 1
Time(seconds=1) < Duration(seconds=2)
Time(seconds=1) < None
-Time()
bool(Time())
sorted([Time(seconds=2), Time(seconds=1)])
max(Time(seconds=2), Time(seconds=1))

# -- Duration

Duration()
Duration(seconds=1, nanoseconds=5)
str(Duration(seconds=-1.5))
Duration(seconds=0.1).nanoseconds
Duration(seconds=1.1).nanoseconds
Duration(seconds=-0.5).nanoseconds
Duration(nanoseconds=1.9).nanoseconds
Duration(nanoseconds=-1.9).nanoseconds
Duration(seconds=2**40)
Duration(nanoseconds=2**63)
Duration(nanoseconds=-(2**63))
Duration(1)
Duration(seconds=float('nan'))
Duration(seconds=float('inf'))
Duration(seconds=None)
Duration(seconds=1) + Duration(seconds=1)
Duration(seconds=1) - Duration(seconds=1)
Duration(seconds=1) * 2
-Duration(seconds=1)
Duration(seconds=1) / 2
abs(Duration(seconds=-1))
Duration(seconds=1) == Duration(nanoseconds=10**9)
Duration(seconds=1) != Duration(nanoseconds=10**9)
Duration(seconds=1) < Duration(seconds=2)
Duration(seconds=1) >= Duration(seconds=2)
Duration(seconds=1) == 1
Duration(seconds=1) == object()
Duration(seconds=1) < 1
Duration(seconds=1) == Time(seconds=1)
hash(Duration())
bool(Duration())
Duration(seconds=1.5).to_msg()
Duration(seconds=-1.5).to_msg()
Duration(nanoseconds=-1).to_msg()
Duration(seconds=2**31).to_msg()
Duration.from_msg(DurationMessage(sec=-2, nanosec=500000000))
Duration.from_msg(TimeMessage(sec=1))
Duration.from_msg(1)
Infinite
Infinite.to_msg()
S_TO_NS

# -- clocks without a context

Clock()
Clock().clock_type
Clock(clock_type=ROS)
Clock(clock_type=STEADY)
Clock(clock_type=ClockType.UNINITIALIZED)
Clock(clock_type='x')
Clock(clock_type=1)
type(Clock(clock_type=ROS))
ROSClock()
isinstance(ROSClock(), Clock)
Clock(clock_type=STEADY).now().clock_type
Clock().now().clock_type
ROSClock().now().clock_type
ROSClock().ros_time_is_active
ROSClock().set_ros_time_override(Time(seconds=1, clock_type=ROS))
ROSClock().set_ros_time_override(Time(seconds=1))
ROSClock().set_ros_time_override(1)
Clock(clock_type=SYSTEM).set_ros_time_override
Clock().sleep_for(Duration(nanoseconds=1))
Clock().sleep_until(Time(seconds=1))
Clock().sleep_until(1)
c = ROSClock()
c._set_ros_time_is_active(True)
c.ros_time_is_active
c.set_ros_time_override(Time(seconds=5, clock_type=ROS))
c.now()

# -- jumps

JumpThreshold(min_forward=None, min_backward=None)
JumpThreshold(min_forward=Duration(seconds=1), min_backward=Duration(seconds=1))
JumpThreshold(min_forward=Duration(seconds=-1), min_backward=None)
JumpThreshold(min_forward=None, min_backward=Duration(seconds=0))
JumpThreshold(min_forward=None, min_backward=Duration(seconds=-1), on_clock_change=False)
JumpThreshold(min_forward=None, min_backward=None, on_clock_change=False)
TimeJump(ClockChange.ROS_TIME_ACTIVATED, Duration(seconds=1)).delta
TimeJump(ClockChange.ROS_TIME_NO_CHANGE, Duration(seconds=1)).clock_change
any_change = JumpThreshold(min_forward=None, min_backward=None, on_clock_change=True)
forward = JumpThreshold(min_forward=Duration(seconds=2), min_backward=None, on_clock_change=False)
backward = JumpThreshold(min_forward=None, min_backward=Duration(seconds=-2), on_clock_change=False)
c.create_jump_callback(any_change)
c.create_jump_callback(any_change, pre_callback=1)
seen = []
handles = [
    c.create_jump_callback(
        threshold,
        pre_callback=lambda name=name: seen.append(f'before {name}'),
        post_callback=lambda jump, name=name: seen.append((name, jump.clock_change, jump.delta)),
    )
    for name, threshold in (('change', any_change), ('forward', forward), ('backward', backward))
]
c.set_ros_time_override(Time(seconds=6, clock_type=ROS))
seen
c.set_ros_time_override(Time(seconds=8, clock_type=ROS))
seen
c.set_ros_time_override(Time(seconds=7, clock_type=ROS))
seen
c.set_ros_time_override(Time(seconds=5, clock_type=ROS))
seen
seen.clear()
c._set_ros_time_is_active(False)
[one[:2] if isinstance(one, tuple) else one for one in seen]
seen.clear()
[handle.unregister() for handle in handles]
c._set_ros_time_is_active(True)
seen

# -- with a context

initialized = rclpy.init(args=[])
Clock().sleep_for(Duration(nanoseconds=1))
Clock().sleep_for(Duration(nanoseconds=-1))
Clock().sleep_until(Time(seconds=1, clock_type=SYSTEM))
Clock(clock_type=STEADY).sleep_until(Time(seconds=1, clock_type=SYSTEM))
Clock(clock_type=STEADY).sleep_for(1)
Clock().sleep_until(1)
Clock(clock_type=STEADY).sleep_until(Time(seconds=1, clock_type=STEADY))
n = Node('n')
n.get_clock()
n.get_clock().ros_time_is_active
n.get_clock().now().clock_type
n.get_clock() is n.get_clock()
n.get_clock().sleep_for(Duration(nanoseconds=1))
now = n.get_clock().now()
now < n.get_clock().now()
now.to_msg().sec == now.nanoseconds // 10**9
rclpy.shutdown()
Clock().sleep_for(Duration(seconds=1))
