"""The programs of a simulated fleet: many robots in one process, an operator, a sender of goals."""

ROBOTS = """
import asyncio, os, sys
import goalwire
from example_interfaces.action import Fibonacci
from std_msgs.msg import String
from std_srvs.srv import Trigger

TOPICS = (
    'joint_states odom imu cmd_vel cmd_vel_nav plan map scan clearance world_markers image camera_info '
    'points battery_state emergency_stopped emergency_stop_status joint_command left_wrench right_wrench'
).split()
SERVICES = 'get_joint_state get_battery_status emergency_stop push get_up front_door get_state'.split()
ACTIONS = 'navigate walk left_arm right_arm hands speak'.split()
folder, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])

async def drive(goal):
    with open(f'{folder}/executed', 'a') as file:
        file.write(goal.goal_id.hex() + chr(10))
    await asyncio.sleep(goal.request.order / 10)
    return Fibonacci.Result(sequence=[1])

async def main():
    nodes = []
    for number in range(first, last):
        name = f'r{number}'
        os.environ['ZENOH_SESSION_CONFIG_URI'] = f'{folder}/{name}.json5'
        # Each robot looks at itself alone, so it has a session of its own.
        node = goalwire.Node('body', namespace=f'/{name}', robots=name)
        nodes.append(await node.__aenter__())
        for name in TOPICS:
            node.publisher(String, name)
        for name in SERVICES:
            node.service(Trigger, name, lambda _: Trigger.Response())
        for name in ACTIONS:
            node.action_server(Fibonacci, name, drive)
    print('ready', flush=True)
    while await asyncio.to_thread(sys.stdin.readline):
        [link] = nodes[0].context.session._context.wire.session.protocol.links
        print(len(link.peer.tokens), flush=True)

asyncio.run(main())
"""
"""Arguments: a folder, the first robot, the robot after the last. Each line of the input asks for the number
of tokens that the first robot's session has been sent."""

OPERATOR = """
import asyncio, json, sys, time
import goalwire

async def main():
    start = time.monotonic()
    async with goalwire.Node('eye', robots=sys.argv[1:]) as node:
        changes = node.graph.changes()
        while '/r0/navigate' not in dict(node.graph.served_actions()):
            await anext(changes)
        took = time.monotonic() - start
        [link] = node.context.session._context.wire.session.protocol.links
        seen = len(link.peer.tokens) + len(link.peer.queryables) + len(link.peer.subscribers)
        print(json.dumps([took, seen, time.process_time()]))

asyncio.run(main())
"""
"""Arguments: patterns of robots, none for all. Prints the seconds until the first robot was known, the
number of declarations, and the processor time."""

SENDER = """
import asyncio, collections, json, sys
from example_interfaces.action import Fibonacci
from goalwire.fleet import Fleet

async def main():
    names = [f'r{number}' for number in range(int(sys.argv[1]))]
    order = int(sys.argv[2])
    async with Fleet('dispatch') as fleet:
        await fleet.wait_for(*names, timeout=600)
        print('sends', flush=True)
        reports = await fleet.send(Fibonacci, 'navigate', order=order, parallel=len(names), timeout=900)
        print(json.dumps(collections.Counter(each.status for each in reports)))

asyncio.run(main())
"""
"""Arguments: the number of robots, and the length of their drives in tenths of a second. Prints how the
goals ended."""
