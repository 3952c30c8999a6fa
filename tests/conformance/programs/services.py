"""Services and clients in one process: requests, responses, failures, futures, the end of either."""

import threading

import rclpy
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger

initialized = rclpy.init(args=[])
n = Node('n')
names = iter(f'service_{number}' for number in range(100))


def outcome(callback, request=None, service_type=SetBool, timeout=0.2):
    """Serve with `callback`, call once, spin; tell what became of it."""
    name = next(names)
    service = n.create_service(service_type, name, callback)
    client = n.create_client(service_type, name)
    client.wait_for_service(10)
    future = client.call_async(request or service_type.Request())
    raised = None
    try:
        rclpy.spin_until_future_complete(n, future, timeout_sec=timeout)
    except BaseException as error:
        raised = type(error).__name__
    told = (raised, future.done(), future.result() if future.done() else None)
    n.destroy_client(client)
    n.destroy_service(service)
    return told


def answer(request, response):
    response.success = request.data
    response.message = 'answered'
    return response


async def answer_async(request, response):
    return answer(request, response)


def fail(request, response):
    raise ValueError('boom')


outcome(answer, SetBool.Request(data=True), timeout=10)
outcome(answer_async, SetBool.Request(data=True), timeout=10)
outcome(lambda request, response: SetBool.Response(message='new'), timeout=10)
outcome(lambda request, response: None)
outcome(lambda request, response: True)
outcome(lambda request, response: Trigger.Response())
outcome(lambda request, response: request)
outcome(lambda request, response: SetBool.Response)
outcome(fail)
outcome(lambda request: None)
outcome(None)
outcome(lambda request, response: Trigger.Response(success=True), service_type=Trigger, timeout=10)

# -- clients

c = n.create_client(SetBool, 'nobody')
c.service_is_ready()
c.wait_for_service(timeout_sec=0.01)
c.wait_for_service(0)
c.call_async(1)
c.call_async(None)
c.call_async(SetBool)
c.call_async(SetBool.Response())
c.call_async(Trigger.Request())
c.call(1)
c.call(SetBool.Request(), timeout_sec=0.01)
f = c.call_async(SetBool.Request(data=True))
isinstance(f, Future)
(f.done(), f.cancelled(), f.result(), f.exception())
f.cancel()
(f.done(), f.cancelled(), f.result())
c.get_pending_request(77)
c.remove_pending_request(Future())
n.destroy_client(c)
(f.done(), f.cancelled())
c.call_async(SetBool.Request())
c.call(SetBool.Request(), timeout_sec=0.01)
c.wait_for_service(0.01)

# -- one server, many calls

s = n.create_service(SetBool, 'many', answer)
c = n.create_client(SetBool, 'many')
c.wait_for_service(10)
c.service_is_ready()
seen = []
futures = [c.call_async(SetBool.Request(data=bool(number % 2))) for number in range(4)]
[future.add_done_callback(lambda future, k=k: seen.append(k)) for k, future in enumerate(futures)]
[rclpy.spin_until_future_complete(n, future, timeout_sec=10) for future in futures]
[future.result().success for future in futures]
for _ in range(100):
    if len(seen) < 4:
        rclpy.spin_once(n, timeout_sec=0.05)
sorted(seen)
f = c.call_async(SetBool.Request(data=True))
c.remove_pending_request(f)
c.remove_pending_request(f)
rclpy.spin_until_future_complete(n, f, timeout_sec=0.1)
f.done()
late = c.call_async(SetBool.Request())
rclpy.spin_until_future_complete(n, late, timeout_sec=10)
late.add_done_callback(lambda future: seen.append('late'))
rclpy.spin_once(n, timeout_sec=0)
seen[-1]
n.destroy_service(s)
s.send_response(SetBool.Response(), None)
s.service_name

# -- a blocking call while another thread spins

other = Node('other')
group = MutuallyExclusiveCallbackGroup()
s = other.create_service(SetBool, 'blocking', answer, callback_group=group)
c = n.create_client(SetBool, 'blocking')
c.wait_for_service(10)
executor = SingleThreadedExecutor()
executor.add_node(other)
executor.add_node(n)
thread = threading.Thread(target=executor.spin, daemon=True)
thread.start()
c.call(SetBool.Request(data=True))
c.call(SetBool.Request(data=False), timeout_sec=10)
c.call('x')
n.create_client(SetBool, 'nosuch').call(SetBool.Request(), timeout_sec=0.01)
executor.shutdown()
thread.join(10)
thread.is_alive()
s.callback_group is group
s.handle.__class__.__name__
c.handle.__class__.__name__

# -- awaiting a client in a callback

reentrant = ReentrantCallbackGroup()
executor = MultiThreadedExecutor(4)
executor.add_node(other)
executor.add_node(n)
finished = Future()
mine = n.create_client(SetBool, 'blocking', callback_group=reentrant)


async def ask():
    timer.cancel()
    result = await mine.call_async(SetBool.Request(data=True))
    finished.set_result(result)


timer = n.create_timer(0.001, ask, callback_group=reentrant)
executor.spin_until_future_complete(finished, timeout_sec=10)
finished.result()
executor.shutdown()
rclpy.shutdown()
c.call_async(SetBool.Request())
c.wait_for_service(0.01)
c.service_is_ready()
