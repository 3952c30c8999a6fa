"""The programs of a simulated fleet: many robots in one process, an operator, two senders of goals."""

ROBOTS = """
import asyncio, os, sys
import goalwire
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from std_msgs.msg import String
from std_srvs.srv import Trigger

TOPICS = (
    'joint_states odom imu cmd_vel cmd_vel_nav plan map scan clearance world_markers image camera_info '
    'points battery_state emergency_stopped emergency_stop_status joint_command left_wrench right_wrench'
).split()
SERVICES = 'get_joint_state get_battery_status emergency_stop get_up front_door get_state'.split()
ACTIONS = 'navigate walk left_arm right_arm hands speak'.split()
folder, first, last = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
if sys.argv[4] == 'few':
    TOPICS, ACTIONS = ('battery_state', 'emergency_stopped', 'emergency_stop_status'), ('navigate',)
    SERVICES = ('get_joint_state', 'get_battery_status', 'emergency_stop')

def note(file, what):
    with open(f'{folder}/{file}', 'a') as lines:
        lines.write(str(what) + chr(10))

def push(request):
    note('handled', request.a)
    return AddTwoInts.Response(sum=request.a + request.b)

async def drive(goal):
    note('executed', goal.goal_id.hex())
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
        node.service(AddTwoInts, 'push', push)
        for name in ACTIONS:
            node.action_server(Fibonacci, name, drive)
    print('ready', flush=True)
    while await asyncio.to_thread(sys.stdin.readline):
        links = nodes[0].context.session._context.wire.session.protocol.links  # none, if it is broken now
        print(sum(len(link.peer.tokens) for link in links), flush=True)

asyncio.run(main())
"""
"""Arguments: a folder, the first robot, the robot after the last, and 'all' names of the humanoid or 'few',
which an operator needs: battery, stop, joint states and one action. Each line of the input asks for the
number of tokens that the first robot's session has been sent."""

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
    def note(report):
        if report.status != 'RUNNING' and not report.goal_id:
            with open(sys.argv[3], 'a') as lines:
                lines.write(report.robot + chr(10))
    async with Fleet('dispatch') as fleet:
        await fleet.wait_for(*names, timeout=600)
        print('sends', flush=True)
        reports = await fleet.send(
            Fibonacci, 'navigate', order=order, parallel=len(names), timeout=900, on_change=note
        )
        print(json.dumps(collections.Counter(each.status for each in reports)))

asyncio.run(main())
"""
"""Arguments: the number of robots, the length of their drives in tenths of a second, and a file for the names
of robots that were not sent their goals, since no link led to them. Prints how the goals ended."""

DISPATCHER = """
import asyncio, collections, itertools, os, random, sys, time, uuid
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from goalwire.errors import GoalwireError, NoRobotError
from goalwire.fleet import Fleet

folder, robots, seconds = sys.argv[1], int(sys.argv[2]), float(sys.argv[3])
LIMIT_S = 180
end = time.monotonic() + seconds
file = os.open(f'{folder}/told', os.O_WRONLY | os.O_APPEND | os.O_CREAT)
numbers = itertools.count(1)

def tell(*words):
    os.write(file, (chr(9).join(map(str, words)) + chr(10)).encode())

def some_tenths():
    return random.randint(10, 100)

async def send_jobs(fleet, robot):
    while time.monotonic() < end:
        key = ''
        def note(report):
            nonlocal key
            if report.status == 'RUNNING':
                key = report.goal_id
                tell('sent', 'goal of a job', key)
        try:
            [report] = await fleet.send(
                Fibonacci, 'navigate', order=some_tenths(), robots=[robot], timeout=LIMIT_S, on_change=note
            )
            outcome = report.status
        except NoRobotError:
            outcome = 'NoRobotError'
        if not key:
            key = f'unsent {next(numbers)}'
            tell('sent', 'goal of a job', key)
        tell('ended', 'goal of a job', key, outcome)
        await asyncio.sleep(1)

async def send_goals(fleet, robot):
    walk = fleet.node.action(Fibonacci, fleet.name_on(robot, 'walk'))
    while time.monotonic() < end:
        goal_id = uuid.uuid4()
        tell('sent', 'goal', goal_id.hex)
        outcome = 'SUCCEEDED'
        try:
            async with walk.send(order=some_tenths(), timeout=LIMIT_S, goal_id=goal_id) as run:
                await run.result
        except GoalwireError as error:
            outcome = type(error).__name__
        tell('ended', 'goal', goal_id.hex, outcome)
        await asyncio.sleep(1)

async def call(fleet, robot):
    push = fleet.node.client(AddTwoInts, fleet.name_on(robot, 'push'))
    while time.monotonic() < end:
        number = next(numbers)
        tell('sent', 'call', number)
        try:
            answer = await push.call(AddTwoInts.Request(a=number, b=1), timeout=10)
            outcome = 'SUCCEEDED' if answer.sum == number + 1 else 'wrong answer'
        except GoalwireError as error:
            outcome = type(error).__name__
        tell('ended', 'call', number, outcome)
        await asyncio.sleep(1)

async def main():
    names = [f'r{number}' for number in range(robots)]
    async with Fleet('dispatch') as fleet, asyncio.TaskGroup() as group:
        await fleet.wait_for(*names, timeout=120)
        print('sends', flush=True)
        for name in names:
            for each in (send_jobs, send_goals, call):
                group.create_task(each(fleet, name))
    print('has ended', flush=True)

asyncio.run(main())
"""
"""Arguments: a folder, the number of robots, and for how many seconds to begin new work.

For each robot there are three loops: one sends goals as durable jobs, one sends goals without a journal, one
makes calls. The file `told` has a line for each goal and call that is sent, and a line for its end. Both hold
the goal's id or the call's number, which the robots write into files of theirs when they run it.
"""
