"""A managed node's callbacks: which run, what they see, and where what they say leads."""

from __future__ import annotations

import gc
import threading

import pytest
import rclpy.lifecycle
from helpers.patience import PATIENCE
from rclpy.context import Context
from rclpy.exceptions import NotInitializedException
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import (
    LifecycleNode,
    LifecycleNodeMixin,
    LifecycleState,
    ManagedEntity,
    SimpleManagedEntity,
    TransitionCallbackReturn,
)
from rclpy.node import Node
from rclpy.publisher import Publisher
from std_msgs.msg import String

from goalwire.errors import RCLError

SUCCESS, FAILURE, ERROR = TransitionCallbackReturn
NOT_REGISTERED = 'Failed to trigger lifecycle state machine transition: Transition is not registered.'


@pytest.fixture
def transport_name() -> str:
    """Nothing here is the wire's business."""
    return 'goalwire_memory'


class Scripted(LifecycleNode):
    """Its callbacks answer as told, by default SUCCESS; `calls` tells of each with the state that it saw."""

    def __init__(self, context: Context, **answers: object) -> None:
        super().__init__('scripted', context=context)
        self.calls: list[tuple[str, str, int]] = []
        self.answers = answers

    def _answer(self, callback: str, state: LifecycleState) -> TransitionCallbackReturn:
        self.calls.append((callback, *state))
        answer = self.answers.get(callback, SUCCESS)
        if isinstance(answer, BaseException):
            raise answer
        return answer  # type: ignore[return-value]  # what is wrong is wrong on purpose

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._answer('on_configure', state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._answer('on_cleanup', state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._answer('on_shutdown', state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._answer('on_activate', state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._answer('on_deactivate', state)

    def on_error(self, state: LifecycleState) -> TransitionCallbackReturn:
        return self._answer('on_error', state)

    @property
    def state(self) -> str:
        return self._state_machine.current_state[1]


def test_the_short_names_are_the_same_classes() -> None:
    assert rclpy.lifecycle.Node is LifecycleNode
    assert rclpy.lifecycle.NodeMixin is LifecycleNodeMixin
    assert rclpy.lifecycle.State is LifecycleState
    assert rclpy.lifecycle.Publisher is rclpy.lifecycle.LifecyclePublisher


def test_a_callback_gets_the_state_that_the_transition_started_in(context: Context) -> None:
    node = Scripted(context)
    steps = ['configure', 'activate', 'deactivate', 'cleanup', 'shutdown']
    assert [getattr(node, f'trigger_{step}')() for step in steps] == [SUCCESS] * 5
    assert node.calls == [
        ('on_configure', 'unconfigured', 1),
        ('on_activate', 'inactive', 2),
        ('on_deactivate', 'active', 3),
        ('on_cleanup', 'inactive', 2),
        ('on_shutdown', 'unconfigured', 1),
    ]
    assert node.state == 'finalized'


@pytest.mark.parametrize(
    ('steps', 'refused', 'number', 'state'),
    [
        ([], 'activate', 3, 'unconfigured'),
        ([], 'deactivate', 4, 'unconfigured'),
        ([], 'cleanup', 2, 'unconfigured'),
        (['configure'], 'configure', 1, 'inactive'),
        (['configure', 'activate'], 'cleanup', 2, 'active'),
        (['shutdown'], 'configure', 1, 'finalized'),
    ],
)
def test_a_transition_that_is_not_there_is_warned_of_and_raised(
    context: Context,
    capfd: pytest.CaptureFixture[str],
    steps: list[str],
    refused: str,
    number: int,
    state: str,
) -> None:
    node = Scripted(context)
    for step in steps:
        getattr(node, f'trigger_{step}')()
    node.calls.clear()
    with pytest.raises(RCLError, match=f"^{NOT_REGISTERED} From '{state}' there are: "):
        getattr(node, f'trigger_{refused}')()
    warning = f'[rcl_lifecycle]: No transition matching {number} found for current state {state}'
    assert warning in capfd.readouterr().err
    assert (node.state, node.calls) == (state, [])


def test_a_finalized_node_cannot_be_shut_down(context: Context) -> None:
    node = Scripted(context)
    node.trigger_shutdown()
    with pytest.raises(RCLError, match=r'^Shutdown transtion not possible: the node is .finalized.$'):
        node.trigger_shutdown()


@pytest.mark.parametrize('steps', [[], ['configure'], ['configure', 'activate']], ids=len)
def test_a_node_can_be_shut_down_from_every_other_state(context: Context, steps: list[str]) -> None:
    node = Scripted(context)
    for step in steps:
        getattr(node, f'trigger_{step}')()
    before = node.state
    assert node.trigger_shutdown() is SUCCESS
    assert node.calls[-1][:2] == ('on_shutdown', before)
    assert node.state == 'finalized'


@pytest.mark.parametrize(
    ('answers', 'said', 'callbacks', 'state'),
    [
        ({'on_configure': FAILURE}, FAILURE, ['on_configure'], 'unconfigured'),
        ({'on_configure': ERROR}, ERROR, ['on_configure', 'on_error'], 'unconfigured'),
        ({'on_configure': ERROR, 'on_error': FAILURE}, ERROR, ['on_configure', 'on_error'], 'finalized'),
        ({'on_configure': ERROR, 'on_error': ERROR}, ERROR, ['on_configure', 'on_error'], 'finalized'),
        ({'on_configure': KeyError('disc')}, ERROR, ['on_configure', 'on_error'], 'unconfigured'),
        (
            {'on_configure': ValueError('a'), 'on_error': ValueError('b')},
            ERROR,
            ['on_configure', 'on_error'],
            'finalized',
        ),
        ({'on_configure': None}, ERROR, ['on_configure', 'on_error'], 'unconfigured'),
        ({'on_configure': True}, ERROR, ['on_configure', 'on_error'], 'unconfigured'),
        ({'on_configure': ERROR, 'on_error': None}, ERROR, ['on_configure', 'on_error'], 'finalized'),
    ],
)
def test_what_a_callback_says_decides_where_the_node_rests(
    context: Context,
    answers: dict[str, object],
    said: TransitionCallbackReturn,
    callbacks: list[str],
    state: str,
) -> None:
    node = Scripted(context, **answers)
    assert node.trigger_configure() is said
    assert node.calls == [(callback, 'unconfigured', 1) for callback in callbacks]
    assert node.state == state


def test_the_error_callback_gets_the_state_before_the_transition(context: Context) -> None:
    node = Scripted(context, on_deactivate=ERROR)
    node.trigger_configure()
    node.trigger_activate()
    assert node.trigger_deactivate() is ERROR
    assert node.calls[-1] == ('on_error', 'active', 3)
    assert node.state == 'unconfigured'


def test_an_exception_in_a_callback_is_logged_with_its_traceback(
    context: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    Scripted(context, on_configure=KeyError('no disc')).trigger_configure()
    logged = capfd.readouterr().err
    assert "[scripted]: Error raised in on_configure(): 'no disc'\nTraceback" in logged
    assert 'in _answer\n    raise answer' in logged


@pytest.mark.parametrize('answer', [None, True, 97, 'SUCCESS'])
def test_an_answer_that_is_none_is_logged_with_what_to_return(
    context: Context, capfd: pytest.CaptureFixture[str], answer: object
) -> None:
    Scripted(context, on_configure=answer).trigger_configure()
    wanted = f'on_configure() returned {answer!r}; return TransitionCallbackReturn.SUCCESS, FAILURE or ERROR'
    assert wanted in capfd.readouterr().err


def test_a_coroutine_is_no_transition_callback_and_the_log_says_so(
    context: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    async def on_configure() -> TransitionCallbackReturn:
        return SUCCESS

    node = Scripted(context, on_configure=on_configure())
    assert node.trigger_configure() is ERROR
    gc.collect()  # a coroutine that nobody closed would warn here
    assert 'on_configure() is a coroutine; a transition has no executor to run one' in capfd.readouterr().err


def test_a_program_stopped_in_a_callback_leaves_the_node_finalized(context: Context) -> None:
    node = Scripted(context, on_configure=KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        node.trigger_configure()
    assert node.calls == [('on_configure', 'unconfigured', 1)]
    assert node.state == 'finalized'


def test_a_callback_cannot_begin_a_transition_itself(context: Context) -> None:
    class Hasty(LifecycleNode):
        def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
            for trigger in (self.trigger_activate, self.trigger_shutdown):
                with pytest.raises(RCLError):
                    trigger()
            return SUCCESS

    node = Hasty('hasty', context=context)
    assert node.trigger_configure() is SUCCESS
    assert node._state_machine.current_state == (2, 'inactive')


def test_of_two_threads_that_ask_at_once_one_is_refused(context: Context) -> None:
    inside, go_on = threading.Event(), threading.Event()

    class Slow(LifecycleNode):
        def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
            inside.set()
            assert go_on.wait(PATIENCE)
            return SUCCESS

    node = Slow('slow', context=context)
    first = threading.Thread(target=node.trigger_configure)
    first.start()
    assert inside.wait(PATIENCE)
    with pytest.raises(RCLError, match=r"A transition is under way \('configuring'\): wait for its end"):
        node.trigger_configure()
    go_on.set()
    first.join()
    assert node._state_machine.current_state == (2, 'inactive')


def test_a_node_goes_through_its_transitions_after_the_end_of_its_context_in_silence(
    context: Context, capfd: pytest.CaptureFixture[str]
) -> None:
    node = Scripted(context)
    node.trigger_configure()
    context.shutdown()
    assert (node.trigger_cleanup(), node.state) == (SUCCESS, 'unconfigured')
    node.destroy_node()
    assert (node.trigger_shutdown(), node.state) == (SUCCESS, 'finalized')
    assert capfd.readouterr().err == ''


def test_before_init_there_is_no_managed_node() -> None:
    with pytest.raises(NotInitializedException):
        LifecycleNode('early', context=Context())


def test_a_node_and_the_mixin_make_a_managed_node_too(context: Context) -> None:
    class Mixed(Node, LifecycleNodeMixin):
        def __init__(self) -> None:
            Node.__init__(self, 'mixed', context=context)
            LifecycleNodeMixin.__init__(self, enable_communication_interface=False)

    assert Mixed().trigger_configure() is SUCCESS


@pytest.mark.parametrize('offered', [True, False])
def test_the_state_machine_has_the_services_that_are_offered(offered: bool, context: Context) -> None:
    node = LifecycleNode('lamp', enable_communication_interface=offered, context=context)
    machine = node._state_machine
    services = [
        machine.service_change_state,
        machine.service_get_state,
        machine.service_get_available_states,
        machine.service_get_available_transitions,
        machine.service_get_transition_graph,
    ]
    assert [service is not None for service in services] == [offered] * 5


def test_a_communication_interface_must_be_a_bool(context: Context) -> None:
    with pytest.raises(
        TypeError, match='enable_communication_interface of a lifecycle node: expected bool, got str'
    ):
        LifecycleNode('lamp', enable_communication_interface='no', context=context)  # type: ignore[arg-type]


# -- managed entities ----------------------------------------------------------------------------------------


class Recorder(ManagedEntity):
    """Notes its callbacks in a list shared with others."""

    def __init__(self, name: str, log: list[str], answer: object = SUCCESS) -> None:
        self.name = name
        self.log = log
        self.answer = answer

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.log.append(f'{self.name} {state.label}')
        return self.answer  # type: ignore[return-value]

    __hash__ = None  # type: ignore[assignment]  # an entity need not be hashable


def test_entities_are_called_in_the_order_in_which_they_were_added(context: Context) -> None:
    node, log = LifecycleNode('node', context=context), list[str]()
    entities = [Recorder(name, log) for name in 'hbxaq']
    for entity in [*entities, entities[0]]:
        node.add_managed_entity(entity)
    assert node.trigger_configure() is SUCCESS
    assert log == [f'{name} unconfigured' for name in 'hbxaq']


@pytest.mark.parametrize('answer', [FAILURE, ERROR])
def test_the_first_entity_that_does_not_succeed_ends_the_round(
    context: Context, answer: TransitionCallbackReturn
) -> None:
    node, log = LifecycleNode('node', context=context), list[str]()
    for entity in (Recorder('a', log), Recorder('b', log, answer), Recorder('c', log)):
        node.add_managed_entity(entity)
    assert node.trigger_configure() is answer
    assert log == ['a unconfigured', 'b unconfigured']


def test_an_entity_with_a_wrong_answer_is_named(context: Context, capfd: pytest.CaptureFixture[str]) -> None:
    node = LifecycleNode('node', context=context)
    node.add_managed_entity(Recorder('a', [], None))
    assert node.trigger_configure() is ERROR
    assert 'Recorder.on_configure() returned None; return Trans' in capfd.readouterr().err


def test_what_is_no_managed_entity_is_refused(context: Context) -> None:
    node = LifecycleNode('node', context=context)
    with pytest.raises(TypeError, match=r'^Expected a rclpy\.lifecycle\.ManagedEntity instance\.$'):
        node.add_managed_entity(5)  # type: ignore[arg-type]


def test_a_publisher_is_silent_unless_its_node_is_active(context: Context) -> None:
    node, heard = LifecycleNode('node', context=context), list[str]()
    publisher = node.create_lifecycle_publisher(String, 'chatter', 10)
    node.create_subscription(String, 'chatter', lambda message: heard.append(message.data), 10)
    for step in ('configure', 'activate', 'deactivate', 'activate', 'deactivate', 'cleanup'):
        publisher.publish(String(data=f'before {step}'))
        getattr(node, f'trigger_{step}')()
        assert publisher.is_activated is (step == 'activate')
    Publisher.publish(publisher, String(data='the end'))
    with SingleThreadedExecutor(context=context) as executor:
        executor.add_node(node)
        while 'the end' not in heard:
            executor.spin_once(timeout_sec=PATIENCE)
    assert heard == ['before deactivate', 'before deactivate', 'the end']


@pytest.mark.parametrize('method', ['destroy_lifecycle_publisher', 'destroy_publisher'])
def test_a_destroyed_publisher_is_managed_no_longer(context: Context, method: str) -> None:
    node = LifecycleNode('node', context=context)
    publisher = node.create_lifecycle_publisher(String, 'chatter', 10)
    destroy = getattr(node, method)
    assert (destroy(publisher), destroy(publisher)) == (True, False)
    node.trigger_configure()
    node.trigger_activate()
    assert not publisher.is_activated


def test_a_managed_publisher_has_no_other_class(context: Context) -> None:
    node = LifecycleNode('node', context=context)
    with pytest.raises(TypeError, match=r"create_publisher\(\) got an unexpected keyword argument 'pub"):
        node.create_lifecycle_publisher(String, 'chatter', 10, publisher_class=rclpy.lifecycle.Publisher)


def test_a_decorated_method_runs_while_its_entity_is_enabled() -> None:
    asked = []

    class Lamp(SimpleManagedEntity):
        @SimpleManagedEntity.when_enabled
        def shine(self, watts: int) -> int:
            """Give light."""
            return watts

        @SimpleManagedEntity.when_enabled(when_not_enabled=lambda: asked.append('dark'))
        def blink(self, *, times: int) -> int:
            return times

    lamp = Lamp()
    assert (lamp.shine(5), lamp.blink(times=2), asked) == (None, None, ['dark'])
    lamp.on_activate(LifecycleState('inactive', 2))
    assert (lamp.shine(5), lamp.blink(times=2), asked) == (5, 2, ['dark'])
    lamp.on_deactivate(LifecycleState('active', 3))
    assert lamp.shine(5) is None
    assert (Lamp.shine.__name__, Lamp.shine.__doc__) == ('shine', 'Give light.')
