"""roslibpy, as its users write it: a topic, a service, a goal that ends and one that is cancelled."""

import sys
import threading

import roslibpy

robot = roslibpy.Ros(sys.argv[1])
robot.run()
print('topics', '/say' in robot.get_topics())
print('parameter', robot.get_param('/robot:speed'))
print('sum', roslibpy.Service(robot, '/add', 'example_interfaces/AddTwoInts').call({'a': 1, 'b': 2})['sum'])

heard = threading.Event()
topic = roslibpy.Topic(robot, '/say', 'std_msgs/String')
topic.subscribe(lambda message: (print('heard', message['data']), heard.set()))
topic.publish({'data': 'roslibpy'})
heard.wait(20)

action = roslibpy.ActionClient(robot, '/fibonacci', 'example_interfaces/action/Fibonacci')


def run(order, on_feedback):
    ended = threading.Event()

    def end(result):
        print(result['status'], result['values'])
        ended.set()

    goal = action.send_goal(roslibpy.Goal({'order': order}), end, lambda feedback: on_feedback(goal), end)
    ended.wait(20)


run(4, lambda _goal: None)
run(3000, action.cancel_goal)
robot.terminate()
