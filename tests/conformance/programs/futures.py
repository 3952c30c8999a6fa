"""Futures and tasks."""

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future, Task

f = Future()
(f.done(), f.cancelled(), f.result(), f.exception())
f.set_result(1)
(f.done(), f.result(), f.cancelled())
f.set_result(2)
f.result()
f.cancel()
(f.done(), f.cancelled())
f.set_exception(ValueError('x'))
f.result()
f.exception()
bool(Future())
Future() == Future()
g = Future()
g.set_exception(ValueError('v'))
(g.done(), g.exception())
g.result()
g.set_exception('notexc')
h = Future()
h.cancel()
(h.done(), h.cancelled(), h.result(), h.exception())
h.set_result(3)
(h.result(), h.done(), h.cancelled())
log = []
k = Future()
k.add_done_callback(lambda future: log.append(future is k))
k.add_done_callback(lambda future: log.append('b'))
log
k.set_result(5)
log
k.add_done_callback(lambda future: log.append('late'))
log
k.add_done_callback(None)
k.add_done_callback(lambda future: 1 / 0)
o = Future()
o.add_done_callback(lambda future: log.append('cancelled'))
o.cancel()
log
o.cancel()
log


async def coroutine():
    return 7


async def failing():
    raise ValueError('in coroutine')


# -- tasks

t = Task(lambda x: x * 2, args=(3,))
(t.done(), t.executing())
t()
(t.done(), t.result(), t.executing())
t = Task(coroutine)
t()
t.result()
t = Task(coroutine())
t()
t.result()
t = Task(failing)
t()
(t.done(), t.exception())
t.result()
t = Task(lambda: 1 / 0)
t()
t.exception()
t = Task(lambda x, y: x + y, args=[1], kwargs={'y': 2})
t()
t.result()
Task(5)
t = Task(lambda: 1)
t.cancel()
(t.done(), t.cancelled())

# -- tasks of an executor

initialized = rclpy.init(args=[])
e = SingleThreadedExecutor()
t = e.create_task(lambda a, b: a + b, 1, b=3)
type(t)
e.spin_until_future_complete(t, 10)
t.result()
t = e.create_task(coroutine)
e.spin_until_future_complete(t, 10)
t.result()
t = e.create_task(coroutine())
e.spin_until_future_complete(t, 10)
t.result()
t = e.create_task(lambda: 1 / 0)
e.spin_until_future_complete(t, 10)
(t.done(), t.exception())
t = e.create_task(failing)
e.spin_once(timeout_sec=10)
(t.done(), t.exception())
first = Future()


async def waits():
    log.append('waits')
    value = await first
    log.append(value)
    return value


log.clear()
t = e.create_task(waits)
e.spin_once(timeout_sec=0.1)
(log, t.done())
first.set_result('woken')
e.spin_until_future_complete(t, 10)
(log, t.result())
second = Future()


async def catches():
    try:
        await second
    except ValueError as error:
        return f'caught {error}'


t = e.create_task(catches)
e.spin_once(timeout_sec=0.1)
second.set_exception(ValueError('second'))
e.spin_until_future_complete(t, 10)
t.result()
own = Future(executor=e)
log.clear()
own.add_done_callback(lambda future: log.append(future.result()))
own.set_result('later')
log
e.spin_once(timeout_sec=10)
log


async def nested():
    return await e.create_task(coroutine) + 1


t = e.create_task(nested)
e.spin_until_future_complete(t, 10)
t.result()
e.shutdown()
rclpy.shutdown()
