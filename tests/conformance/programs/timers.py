"""Timers, rates and guard conditions."""

import inspect
import threading
import time

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.node import Node
from rclpy.time import Time

initialized = rclpy.init(args=[])
n = Node('n')
log = []
t = n.create_timer(60.0, lambda: log.append(1))
t.timer_period_ns
t.is_ready()
t.is_canceled()
(0 < t.time_until_next_call() <= 60 * 10**9, type(t.time_until_next_call()))
(0 <= t.time_since_last_call() < 10**9, type(t.time_since_last_call()))
rclpy.spin_once(n, timeout_sec=0)
log
t.cancel()
t.cancel()
t.is_canceled()
t.is_ready()
t.time_until_next_call()
t.reset()
t.is_canceled()
0 < t.time_until_next_call() <= 60 * 10**9
t.timer_period_ns = 10**9
t.timer_period_ns
t.timer_period_ns = 'x'
t.timer_period_ns = None
t.timer_period_ns = -5
t.timer_period_ns
t.timer_period_ns = 1.5
t.timer_period_ns
t.clock
t.clock is n.get_clock()
t.handle.__class__.__name__
n.destroy_timer(t)
t.is_ready()
t.timer_period_ns
t.cancel()
t.reset()
t.destroy()
u = n.create_timer(0.001, lambda: log.append('u'), autostart=False)
(u.is_canceled(), u.is_ready())
u.time_until_next_call()
time.sleep(0.002)
rclpy.spin_once(n, timeout_sec=0.0)
log
u.reset()
u.is_canceled()
rclpy.spin_once(n, timeout_sec=10)
log
u.destroy()
n.destroy_timer(u)
n.create_timer(0.1 + 0.2, print, autostart=False).timer_period_ns
n.create_timer(True, print, autostart=False).timer_period_ns
n.create_timer('0.5', print, autostart=False).timer_period_ns
n.create_timer(float('inf'), print)
n.create_timer(float('nan'), print)
n.create_timer(1e10, print)
n.create_timer(1, print, clock=Clock(clock_type=ClockType.STEADY_TIME), autostart=False).clock
n.create_timer(1, print, clock=1)
list(inspect.signature(n.create_timer).parameters)
[n.destroy_timer(timer) for timer in list(n.timers)]

# -- when callbacks run

log.clear()
cancelling = n.create_timer(0.001, lambda: (log.append('cancelling'), cancelling.cancel()))
rclpy.spin_once(n, timeout_sec=10)
rclpy.spin_once(n, timeout_sec=0.02)
(len(log), cancelling.is_canceled())
n.destroy_timer(cancelling)
destroying = n.create_timer(0.001, lambda: (log.append('destroying'), n.destroy_timer(destroying)))
rclpy.spin_once(n, timeout_sec=10)
rclpy.spin_once(n, timeout_sec=0.02)
len(log)
log.clear()
slow = n.create_timer(60, lambda: log.append('slow'))
slow.timer_period_ns = 10**6
time.sleep(0.002)
rclpy.spin_once(n, timeout_sec=0)
len(log)
slow.reset()
rclpy.spin_once(n, timeout_sec=10)
log
n.destroy_timer(slow)


def failing():
    raise ValueError('boom')


async def failing_later():
    raise ValueError('later')


def ticking(callback):
    """Let a timer with this callback tick once."""
    timer = n.create_timer(0.001, callback)
    try:
        rclpy.spin_once(n, timeout_sec=10)
    finally:
        n.destroy_timer(timer)


ticking(failing)
ticking(failing_later)
ticking(None)
ticking(5)
ticking(lambda info: None)

# -- a timer on simulated time

clock = Clock(clock_type=ClockType.ROS_TIME)
clock._set_ros_time_is_active(True)
clock.set_ros_time_override(Time(seconds=10, clock_type=ClockType.ROS_TIME))
log.clear()
sim = n.create_timer(1.0, lambda: log.append(clock.now().nanoseconds / 1e9), clock=clock)


def at(seconds):
    """Set the time, spin, and return when the timer ran and how long it has yet to wait."""
    clock.set_ros_time_override(Time(seconds=seconds, clock_type=ClockType.ROS_TIME))
    for _ in range(3):
        rclpy.spin_once(n, timeout_sec=0.01)
    return list(log), sim.time_until_next_call()


at(10.5)
at(11.0)
at(11.2)
at(14.5)
at(14.9)
at(15.0)
at(9.0)
at(9.5)
at(10.0)
n.destroy_timer(sim)

# -- rates

r = n.create_rate(100)
type(r)
thread = threading.Thread(target=lambda: [rclpy.spin_once(n, timeout_sec=0.05) for _ in range(20)])
thread.start()
r.sleep()
r.sleep()
n.destroy_rate(r)
r.sleep()
n.destroy_rate(r)
thread.join()
n.create_rate(0)
n.create_rate(-1.0)

# -- guard conditions

log.clear()
g = n.create_guard_condition(lambda: log.append('guard'))
g.trigger()
rclpy.spin_once(n, timeout_sec=10)
log
g.trigger()
g.trigger()
rclpy.spin_once(n, timeout_sec=10)
rclpy.spin_once(n, timeout_sec=0.01)
log
n.destroy_guard_condition(g)
g.trigger()
rclpy.shutdown()
n.create_rate(1)
