"""Managed nodes: transitions, what callbacks see and say, managed entities, services and events."""

import rclpy
import rclpy.lifecycle
from lifecycle_msgs.msg import Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import LifecycleNode, LifecycleState, ManagedEntity, SimpleManagedEntity
from rclpy.lifecycle import TransitionCallbackReturn as Said
from std_msgs.msg import String

# -- names

[name for name in dir(rclpy.lifecycle) if name[0].isupper()]
rclpy.lifecycle.Node is LifecycleNode
rclpy.lifecycle.NodeMixin is rclpy.lifecycle.LifecycleNodeMixin
rclpy.lifecycle.State is LifecycleState
rclpy.lifecycle.Publisher is rclpy.lifecycle.LifecyclePublisher
LifecycleState('a', 1)
LifecycleState(label='a', state_id=1) == ('a', 1)
Said.SUCCESS
[str(said) for said in (Said.SUCCESS, Said.FAILURE, Said.ERROR)]
[int(said) for said in (Said.SUCCESS, Said.FAILURE, Said.ERROR)]
[said.to_label() for said in (Said.SUCCESS, Said.FAILURE, Said.ERROR)]
Said(97) == Said.SUCCESS, Said.SUCCESS == 97, Said.SUCCESS == Said.SUCCESS
Said.ERROR.name, Said.ERROR.value
ManagedEntity().on_configure(None), ManagedEntity().on_error(None)

LifecycleNode('early')
rclpy.init(args=[])
LifecycleNode('bad name')


class Scripted(LifecycleNode):
    def __init__(self, **answers):
        super().__init__('scripted', enable_communication_interface=False)
        self.calls = []
        self.answers = answers

    def answer(self, callback, state):
        self.calls.append((callback, state.label, state.state_id))
        answer = self.answers.get(callback, Said.SUCCESS)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def on_configure(self, state):
        return self.answer('configure', state)

    def on_cleanup(self, state):
        return self.answer('cleanup', state)

    def on_shutdown(self, state):
        return self.answer('shutdown', state)

    def on_activate(self, state):
        return self.answer('activate', state)

    def on_deactivate(self, state):
        return self.answer('deactivate', state)

    def on_error(self, state):
        return self.answer('error', state)


def walk(*steps, **answers):
    """Go through steps; return what each gave, what the callbacks saw, and the state at the end."""
    node = Scripted(**answers)
    try:
        gave = []
        for step in steps:
            try:
                gave.append(getattr(node, f'trigger_{step}')().name)
            except Exception as error:
                gave.append(type(error).__name__)
        return gave, node.calls, node._state_machine.current_state
    finally:
        node.destroy_node()


# -- where transitions lead

walk()
walk('configure')
walk('configure', 'activate')
walk('configure', 'activate', 'deactivate')
walk('configure', 'activate', 'deactivate', 'cleanup')
walk('configure', 'cleanup', 'configure')
walk('shutdown')
walk('configure', 'shutdown')
walk('configure', 'activate', 'shutdown')
walk('shutdown', 'shutdown', 'configure')
walk('activate', 'deactivate', 'cleanup')
walk('configure', 'configure', 'deactivate')
walk('configure', 'activate', 'activate', 'cleanup', 'configure')

# -- what callbacks say

walk('configure', configure=Said.FAILURE)
walk('configure', configure=Said.ERROR)
walk('configure', configure=Said.ERROR, error=Said.FAILURE)
walk('configure', configure=Said.ERROR, error=Said.ERROR)
walk('configure', configure=ValueError('x'))
walk('configure', configure=ValueError('x'), error=ValueError('y'))
walk('configure', configure=ValueError('x'), error=Said.FAILURE)
walk('configure', 'activate', activate=Said.FAILURE)
walk('configure', 'activate', activate=Said.ERROR)
walk('configure', 'activate', activate=KeyError('x'), error=Said.ERROR)
walk('configure', 'activate', 'deactivate', deactivate=Said.FAILURE)
walk('configure', 'activate', 'deactivate', deactivate=Said.ERROR)
walk('configure', 'cleanup', cleanup=Said.FAILURE)
walk('configure', 'cleanup', cleanup=Said.ERROR)
walk('shutdown', shutdown=Said.FAILURE)
walk('shutdown', shutdown=Said.ERROR)
walk('shutdown', shutdown=Said.ERROR, error=Said.FAILURE)
walk('configure', 'activate', 'shutdown', shutdown=Said.FAILURE)
walk('configure', configure=None)
walk('configure', configure=True)
walk('configure', 'activate', activate='SUCCESS')

# -- managed entities

node = LifecycleNode('managed')
node.add_managed_entity(5)
node.add_managed_entity(None)
node.create_lifecycle_publisher(String, 'chatter', 10, publisher_class=rclpy.lifecycle.Publisher)
publisher = node.create_lifecycle_publisher(String, 'chatter', 10)
publisher.topic_name
isinstance(publisher, SimpleManagedEntity)
publisher.is_activated
publisher.publish(String(data='x'))
node.trigger_configure(), publisher.is_activated
node.trigger_activate(), publisher.is_activated
publisher.publish(5)
node.trigger_deactivate(), publisher.is_activated
publisher.publish(5)
node.destroy_lifecycle_publisher(publisher)
node.destroy_lifecycle_publisher(publisher)
node.trigger_activate(), publisher.is_activated
node.trigger_shutdown()


class Entity(ManagedEntity):
    def __init__(self, name, said):
        self.name = name
        self.said = said

    def on_configure(self, state):
        seen.append((self.name, state))
        return self.said


class Switch(SimpleManagedEntity):
    @SimpleManagedEntity.when_enabled
    def on(self, what):
        seen.append(what)

    @SimpleManagedEntity.when_enabled(when_not_enabled=lambda: seen.append('off'))
    def either(self, *, what):
        seen.append(what)


seen = []
node = LifecycleNode('with_entities', enable_communication_interface=False)
node.add_managed_entity(Entity('one', Said.FAILURE))
node.trigger_configure(), seen, node._state_machine.current_state
switch = Switch()
seen.clear()
switch.on(1), switch.either(what=2), seen
switch.on_activate(None)
seen.clear()
switch.is_activated, switch.on(1), switch.either(what=2), seen
Switch.on.__name__

# -- services and events

node = LifecycleNode('lc', namespace='/lab')
peer = rclpy.create_node('peer')
events = []
listener = peer.create_subscription(TransitionEvent, '/lab/lc/transition_event', events.append, 10)
executor = SingleThreadedExecutor()
executor.add_node(node)
executor.add_node(peer)


def call(srv_type, name, **transition):
    client = peer.create_client(srv_type, f'/lab/lc/{name}')
    client.wait_for_service(10)
    request = srv_type.Request(transition=Transition(**transition)) if transition else srv_type.Request()
    future = client.call_async(request)
    executor.spin_until_future_complete(future, 10)
    return future.result()


def shown(description):
    transition, start, goal = description.transition, description.start_state, description.goal_state
    return transition.id, transition.label, start.id, start.label, goal.id, goal.label


call(GetState, 'get_state')
[(state.id, state.label) for state in call(GetAvailableStates, 'get_available_states').available_states]
[shown(one) for one in call(GetAvailableTransitions, 'get_transition_graph').available_transitions]
[shown(one) for one in call(GetAvailableTransitions, 'get_available_transitions').available_transitions]
call(ChangeState, 'change_state', label='nonsense')
call(ChangeState, 'change_state', label='transition_success')
call(ChangeState, 'change_state', id=1, label='activate')
call(ChangeState, 'change_state', id=1)
call(ChangeState, 'change_state', label='activate')
call(GetState, 'get_state')
[shown(one) for one in call(GetAvailableTransitions, 'get_available_transitions').available_transitions]
call(ChangeState, 'change_state', id=99, label='shutdown')
[shown(one) for one in call(GetAvailableTransitions, 'get_available_transitions').available_transitions]
[(event.start_state.label, event.goal_state.label) for event in events]
sorted(service.srv_name for service in node.services if service.srv_name.startswith('/'))
[publisher.topic_name for publisher in node.publishers if 'transition' in publisher.topic_name]
[one for one in node.get_service_names_and_types_by_node('lc', '/lab') if 'lifecycle' in one[1][0]]
[one for one in node.get_publisher_names_and_types_by_node('lc', '/lab') if 'transition' in one[0]]
quiet = LifecycleNode('quiet', enable_communication_interface=False)
[service.srv_name for service in quiet.services if service.srv_name.startswith('/')]
quiet.count_publishers('/quiet/transition_event')
quiet.trigger_configure()
quiet.destroy_node()
quiet.trigger_activate()
rclpy.shutdown()
