"""Executors: nodes come and go, timeouts, failures, threads, callback groups, shutdown."""

import threading
import time
import warnings

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import (
    Executor,
    ExternalShutdownException,
    MultiThreadedExecutor,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.node import Node
from rclpy.task import Future

warnings.simplefilter('error', UserWarning)
initialized = rclpy.init(args=[])
n = Node('n')


def timed(call, at_least):
    """Return what a call gives, or raises, and whether it took these seconds; a busy machine adds some."""
    start = time.monotonic()
    try:
        gives = call()
    except Exception as error:
        gives = f'{type(error).__name__}: {error}'
    return gives, at_least - 0.01 <= time.monotonic() - start < at_least + 10


# -- nodes

ex = SingleThreadedExecutor()
ex.add_node(n)
ex.add_node(n)
n.executor is ex
ex.get_nodes() == [n]
ex2 = SingleThreadedExecutor()
ex2.add_node(n)
(n.executor is ex, n.executor is ex2, len(ex.get_nodes()), len(ex2.get_nodes()))
ex2.remove_node(n)
ex2.remove_node(n)
n.executor
SingleThreadedExecutor().add_node(5)
n.executor = ex
(n.executor is ex, len(ex.get_nodes()))
n.executor = None
(n.executor, len(ex.get_nodes()))
ex.add_node(n)

# -- timeouts

timed(lambda: ex.spin_once(timeout_sec=0.2), 0.2)
timed(lambda: ex.spin_once(timeout_sec=0), 0)
timed(lambda: ex.spin_once(0.1), 0.1)
timed(lambda: rclpy.spin_once(n, timeout_sec=0.1), 0.1)
n.executor is ex
ex.add_node(n)
f = Future()
timed(lambda: ex.spin_until_future_complete(f, timeout_sec=0.2), 0.2)
timed(lambda: ex.spin_until_future_complete(f, 0), 0)
timed(lambda: rclpy.spin_until_future_complete(n, f, timeout_sec=0.2), 0.2)
f.set_result(1)
timed(lambda: ex.spin_until_future_complete(f), 0)
rclpy.spin_until_future_complete(n, 5, timeout_sec=0.2)
timed(lambda: ex.spin_once_until_future_complete(Future(), 0.1), 0.1)
ex.context is n.context
[issubclass(kind, Executor) for kind in (SingleThreadedExecutor, MultiThreadedExecutor)]
[issubclass(kind, Exception) for kind in (ExternalShutdownException, ShutdownException, TimeoutException)]
MultiThreadedExecutor(num_threads=0)
MultiThreadedExecutor(num_threads='x')
MultiThreadedExecutor(num_threads=1)
SingleThreadedExecutor(context=5)
with SingleThreadedExecutor() as inside:
    print(type(inside).__name__, inside.get_nodes())

# -- failures in callbacks


def failing(executor, make):
    """Spin up to four times; return what came out of it."""
    told = []
    node = Node('failing')
    executor.add_node(node)
    made = make(node)
    for _ in range(4):
        try:
            executor.spin_once(timeout_sec=0.1)
        except Exception as error:
            told.append(f'{type(error).__name__}: {error}')
            break
    node.destroy_node()
    executor.shutdown()
    return told, made is None


def boom(*args):
    raise ValueError('boom')


async def boom_later(*args):
    raise ValueError('later')


def guard(callback):
    def make(node):
        condition = node.create_guard_condition(callback)
        condition.trigger()
        return condition

    return make


failing(SingleThreadedExecutor(), lambda node: node.create_timer(0.001, boom))
failing(SingleThreadedExecutor(), lambda node: node.create_timer(0.001, boom_later))
failing(SingleThreadedExecutor(), guard(boom))
failing(SingleThreadedExecutor(), guard(boom_later))
failing(MultiThreadedExecutor(2), lambda node: node.create_timer(0.001, boom))
failing(MultiThreadedExecutor(2), guard(boom_later))

# -- one callback a turn

log = []
ex = SingleThreadedExecutor()
ex.add_node(n)
guards = [n.create_guard_condition(lambda k=k: log.append(k)) for k in range(3)]
[condition.trigger() for condition in guards]
ex.spin_once(timeout_sec=10)
len(log)
ex.spin_once(timeout_sec=10)
len(log)
ex.spin_once(timeout_sec=10)
sorted(log)
[n.destroy_guard_condition(condition) for condition in guards]

# -- callback groups under several threads


def overlap(first, second, executor):
    """Return whether two callbacks of 0.1 s run at the same time, and whether one does with itself."""
    node, running, seen = Node('groups'), [], set()

    def callback(name):
        seen.update((name, other) for other in running)
        running.append(name)
        time.sleep(0.05)
        running.remove(name)

    for name, group in (('a', first), ('b', second)):
        node.create_timer(0.01, lambda name=name: callback(name), callback_group=group)
    executor.add_node(node)
    end = Future()
    executor.spin_until_future_complete(end, 0.4)
    executor.shutdown()
    node.destroy_node()
    return bool({('a', 'b'), ('b', 'a')} & seen), bool({('a', 'a'), ('b', 'b')} & seen)


exclusive = MutuallyExclusiveCallbackGroup()
reentrant = ReentrantCallbackGroup()
overlap(None, None, MultiThreadedExecutor(4))
overlap(exclusive, exclusive, MultiThreadedExecutor(4))
overlap(MutuallyExclusiveCallbackGroup(), MutuallyExclusiveCallbackGroup(), MultiThreadedExecutor(4))
overlap(reentrant, reentrant, MultiThreadedExecutor(4))
overlap(reentrant, reentrant, SingleThreadedExecutor())
group = MutuallyExclusiveCallbackGroup()
t = n.create_timer(60, print, callback_group=group)
group.has_entity(t)
group.can_execute(t)
group.beginning_execution(t)
group.can_execute(t)
group.beginning_execution(t)
group.ending_execution(t)
group.can_execute(t)
group.add_entity(5)
n.default_callback_group.has_entity(t)
reentrant.can_execute(t)
reentrant.beginning_execution(t)
n.destroy_timer(t)

# -- spinning in a thread while nodes come and go

spinning = SingleThreadedExecutor()
ended = []


def spin():
    try:
        spinning.spin()
        ended.append('returned')
    except BaseException as error:
        ended.append(type(error).__name__)


thread = threading.Thread(target=spin)
thread.start()
late = Node('late')
ran = threading.Event()
late.create_timer(0.001, ran.set)
spinning.add_node(late)
ran.wait(10)
spinning.remove_node(late)
spinning.shutdown()
thread.join(10)
(thread.is_alive(), ended)
spinning.get_nodes()
spinning.shutdown()

# -- wake, and tasks from other threads

waking = SingleThreadedExecutor()
threading.Timer(0.05, waking.wake).start()
timed(lambda: waking.spin_once(timeout_sec=0.3), 0)[0]
done = Future()
threading.Timer(0.05, lambda: waking.create_task(lambda: done.set_result('from afar'))).start()
waking.spin_until_future_complete(done, 10)
done.result()
waking.shutdown()
waking.shutdown(timeout_sec=1)

# -- after shutdown of the executor

over = SingleThreadedExecutor()
over.add_node(late)
over.shutdown()
over.get_nodes()
over.spin_once(timeout_sec=0.1)
over.spin()
over.spin_until_future_complete(Future(), 0.1)

# -- shutdown of the context while a thread spins

ended.clear()
spinning = SingleThreadedExecutor()
spinning.add_node(late)
started = Future()
spinning.create_task(lambda: started.set_result(None))
thread = threading.Thread(target=spin)
thread.start()
[time.sleep(0.01) for _ in range(500) if not started.done()]
started.done()
rclpy.shutdown()
thread.join(10)
(thread.is_alive(), ended)
rclpy.ok()
spinning.spin_once(timeout_sec=0.1)
