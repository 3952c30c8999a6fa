"""The names that rclpy's modules import for their own use, and that programs import from these modules.

Editors write lines such as `from rclpy.node import ParameterDescriptor`, and ROS 2 accepts them. Each name is
imported from its origin at its first use. With plain imports, which would load YAML and ROS 2's own
interfaces, `import rclpy` would take a tenth longer, and `import rclpy.node` twice as long. Source: the
modules of rclpy 7.1.6 (ROS 2 Jazzy).
"""

from __future__ import annotations

import sys
from importlib import import_module

ORIGINS = {
    'action_msgs.msg': 'GoalInfo GoalStatus',
    'action_msgs.srv': 'CancelGoal',
    'collections': 'OrderedDict defaultdict namedtuple',
    'collections.abc': 'Iterable Iterator Sequence',
    'concurrent.futures': 'ThreadPoolExecutor',
    'contextlib': 'ExitStack',
    'enum': 'Enum IntEnum',
    'functools': 'wraps',
    'inspect': 'ismethod',
    'itertools': 'chain',
    'pathlib': 'Path',
    'rcl_interfaces.msg': (
        'FloatingPointRange IntegerRange ListParametersResult LoggerLevel ParameterDescriptor '
        'ParameterEvent ParameterMsg=Parameter ParameterType ParameterValue '
        'QosCallbackResult=SetParametersResult SetLoggerLevelsResult SetParametersResult'
    ),
    'rcl_interfaces.srv': (
        'DescribeParameters GetLoggerLevels GetParameterTypes GetParameters ListParameters SetLoggerLevels '
        'SetParameters SetParametersAtomically'
    ),
    'rclpy._rclpy_pybind11': 'InvalidHandle',
    'rclpy.action.graph': (
        'get_action_client_names_and_types_by_node get_action_names_and_types '
        'get_action_server_names_and_types_by_node'
    ),
    'rclpy.callback_groups': 'CallbackGroup MutuallyExclusiveCallbackGroup ReentrantCallbackGroup',
    'rclpy.client': 'Client',
    'rclpy.clock': 'Clock ROSClock',
    'rclpy.clock_type': 'ClockType',
    'rclpy.constants': 'S_TO_NS',
    'rclpy.context': 'Context',
    'rclpy.duration': 'Duration',
    'rclpy.event_handler': 'EventHandler PublisherEventCallbacks SubscriptionEventCallbacks',
    'rclpy.exceptions': (
        'InvalidNamespaceException InvalidNodeNameException InvalidParameterException '
        'InvalidParameterTypeException InvalidParameterValueException InvalidServiceNameException '
        'InvalidTopicNameException NoTypeSupportImportedException NotInitializedException '
        'ParameterAlreadyDeclaredException ParameterImmutableException ParameterNotDeclaredException '
        'ParameterUninitializedException ROSInterruptException'
    ),
    'rclpy.executors': 'Executor await_or_execute',
    'rclpy.expand_topic_name': 'expand_topic_name',
    'rclpy.guard_condition': 'GuardCondition',
    'rclpy.impl.implementation_singleton': '_rclpy=rclpy_implementation',
    'rclpy.impl.logging_severity': 'LoggingSeverity',
    'rclpy.impl.rcutils_logger': 'RcutilsLogger',
    'rclpy.logging': 'get_logger',
    'rclpy.logging_service': 'LoggingService',
    'rclpy.node': 'Node',
    'rclpy.parameter': 'PARAMETER_SEPARATOR_STRING Parameter parameter_dict_from_yaml_file',
    'rclpy.parameter_service': 'ParameterService',
    'rclpy.publisher': 'Publisher',
    'rclpy.qos': (
        'QoSDurabilityPolicy QoSHistoryPolicy QoSLivelinessPolicy QoSPolicyKind QoSPresetProfiles '
        'QoSProfile QoSReliabilityPolicy ReliabilityPolicy qos_policy_name_from_kind '
        'qos_profile_action_status_default qos_profile_parameter_events qos_profile_parameters '
        'qos_profile_services_default'
    ),
    'rclpy.qos_overriding_options': 'QoSOverridingOptions',
    'rclpy.service': 'Service',
    'rclpy.service_introspection': 'ServiceIntrospectionState',
    'rclpy.subscription': 'Subscription',
    'rclpy.task': 'Future Task',
    'rclpy.time': 'Time',
    'rclpy.time_source': 'TimeSource',
    'rclpy.timer': 'Rate Timer',
    'rclpy.topic_endpoint_info': 'TopicEndpointInfo',
    'rclpy.type_description_service': 'TypeDescriptionService',
    'rclpy.type_hash': 'TypeHash',
    'rclpy.type_support': (
        'MsgType SrvType SrvTypeRequest SrvTypeResponse check_for_type_support check_is_valid_msg_type '
        'check_is_valid_srv_type'
    ),
    'rclpy.utilities': 'get_default_context timeout_sec_to_nsec',
    'rclpy.validate_full_topic_name': 'validate_full_topic_name',
    'rclpy.validate_namespace': 'validate_namespace',
    'rclpy.validate_node_name': 'validate_node_name',
    'rclpy.validate_parameter_name': 'validate_parameter_name',
    'rclpy.validate_topic_name': 'TOPIC_SEPARATOR_STRING validate_topic_name',
    'rclpy.waitable': 'NumberOfEntities Waitable',
    'threading': 'Condition Lock RLock',
    'type_description_interfaces.srv': 'GetTypeDescription',
    'types': 'MethodType TracebackType',
    'typing': (
        'Any Callable ContextManager Coroutine Dict Generator List Literal NamedTuple Optional Protocol Set '
        'TYPE_CHECKING Text Tuple Type TypeVar TypedDict Union'
    ),
    'unique_identifier_msgs.msg': 'UUID',
    'weakref': 'WeakMethod',
}
"""The module that defines each name; `a=b` is the module's b under the name a.

Names missing here are modules.
"""

REEXPORTS = {
    'rclpy.action': (
        'get_action_client_names_and_types_by_node get_action_names_and_types '
        'get_action_server_names_and_types_by_node'
    ),
    'rclpy.action.client': (
        'CancelGoal Future GoalStatus NumberOfEntities QoSProfile UUID Waitable _rclpy await_or_execute '
        'check_for_type_support qos_profile_action_status_default qos_profile_services_default threading '
        'time uuid weakref'
    ),
    'rclpy.action.graph': 'List Node Tuple',
    'rclpy.action.server': (
        'Enum Future GoalInfo GoalStatus NumberOfEntities QoSProfile Waitable _rclpy await_or_execute '
        'check_for_type_support functools qos_profile_action_status_default qos_profile_services_default '
        'threading traceback'
    ),
    'rclpy.callback_groups': 'Lock weakref',
    'rclpy.client': (
        'CallbackGroup Clock Context Dict Future Optional QoSProfile ServiceIntrospectionState SrvType '
        'SrvTypeRequest SrvTypeResponse TypeVar _rclpy threading time'
    ),
    'rclpy.clock': (
        'Callable ClockType Context Duration IntEnum NotInitializedException Optional Protocol '
        'TYPE_CHECKING Time TracebackType Type TypedDict _rclpy get_default_context'
    ),
    'rclpy.clock_type': 'IntEnum _rclpy',
    'rclpy.context': (
        'Callable ContextManager List MethodType Optional Protocol TracebackType Type Union WeakMethod '
        'ismethod sys threading'
    ),
    'rclpy.duration': 'Protocol S_TO_NS Union _rclpy builtin_interfaces',
    'rclpy.event_handler': (
        'Callable CallbackGroup IntEnum List NumberOfEntities Optional Waitable _rclpy get_logger '
        'qos_policy_name_from_kind rclpy warnings'
    ),
    'rclpy.exceptions': 'List Optional TYPE_CHECKING Union _rclpy',
    'rclpy.executors': (
        'Any Callable Client Clock ClockType Condition Context ContextManager Coroutine ExitStack Future '
        'Generator GuardCondition InvalidHandle List Lock NumberOfEntities Optional RLock Service Set '
        'Subscription TYPE_CHECKING Task ThreadPoolExecutor Timer TracebackType Tuple Type TypeVar Union '
        'Waitable _rclpy get_default_context inspect os time timeout_sec_to_nsec warnings'
    ),
    'rclpy.expand_topic_name': '_rclpy',
    'rclpy.experimental.events_executor': '_rclpy rclpy typing',
    'rclpy.guard_condition': '_rclpy get_default_context',
    'rclpy.impl.logging_severity': 'IntEnum _rclpy',
    'rclpy.impl.rcutils_logger': 'Clock LoggingSeverity OrderedDict _rclpy inspect namedtuple os',
    'rclpy.lifecycle': '_rclpy',
    'rclpy.lifecycle.managed_entity': '_rclpy wraps',
    'rclpy.lifecycle.node': (
        'Callable CallbackGroup Dict NamedTuple Node Optional QoSProfile Service Set _rclpy '
        'check_is_valid_srv_type lifecycle_msgs'
    ),
    'rclpy.lifecycle.publisher': 'MsgType Publisher Union',
    'rclpy.logging': 'LoggingSeverity Path RcutilsLogger Union _rclpy',
    'rclpy.logging_service': (
        'GetLoggerLevels LoggerLevel LoggingSeverity SetLoggerLevels SetLoggerLevelsResult '
        'TOPIC_SEPARATOR_STRING TYPE_CHECKING qos_profile_services_default rclpy'
    ),
    'rclpy.node': (
        'Any Callable CallbackGroup Client Clock Context Dict Executor FloatingPointRange GuardCondition '
        'IntegerRange InvalidHandle InvalidParameterTypeException InvalidParameterValueException '
        'InvalidTopicNameException Iterator List ListParameters ListParametersResult LoggingService MsgType '
        'MutuallyExclusiveCallbackGroup NotInitializedException Optional PARAMETER_SEPARATOR_STRING '
        'Parameter ParameterAlreadyDeclaredException ParameterDescriptor ParameterEvent '
        'ParameterImmutableException ParameterMsg ParameterNotDeclaredException ParameterService '
        'ParameterType ParameterUninitializedException ParameterValue Publisher PublisherEventCallbacks '
        'QoSOverridingOptions QoSProfile ROSClock Rate ReentrantCallbackGroup S_TO_NS Sequence Service '
        'SetParametersResult SrvType SrvTypeRequest SrvTypeResponse Subscription SubscriptionEventCallbacks '
        'TimeSource Timer TopicEndpointInfo Tuple Type TypeDescriptionService TypeVar Union Waitable _rclpy '
        'check_is_valid_msg_type check_is_valid_srv_type expand_topic_name get_default_context get_logger '
        'math qos_profile_parameter_events qos_profile_services_default time validate_full_topic_name '
        'validate_namespace validate_node_name validate_parameter_name validate_topic_name warnings weakref'
    ),
    'rclpy.parameter': (
        'Dict Enum List Optional ParameterMsg ParameterType ParameterValue TYPE_CHECKING Tuple Union array '
        'yaml'
    ),
    'rclpy.parameter_client': (
        'Callable CallbackGroup DescribeParameters Future GetParameterTypes GetParameters List '
        'ListParameters Node Optional Parameter ParameterEvent ParameterMsg QoSOverridingOptions QoSProfile '
        'Sequence SetParameters SetParametersAtomically Subscription SubscriptionEventCallbacks Union '
        'parameter_dict_from_yaml_file qos_profile_parameter_events qos_profile_services_default time'
    ),
    'rclpy.parameter_event_handler': (
        'Callable CallbackGroup Dict Iterable List Lock Node Optional Parameter ParameterEvent '
        'QoSOverridingOptions QoSProfile SubscriptionEventCallbacks Tuple chain defaultdict '
        'qos_profile_parameter_events'
    ),
    'rclpy.parameter_service': (
        'DescribeParameters GetParameterTypes GetParameters ListParameters ListParametersResult Parameter '
        'ParameterNotDeclaredException ParameterUninitializedException SetParameters '
        'SetParametersAtomically SetParametersResult TOPIC_SEPARATOR_STRING qos_profile_parameters weakref'
    ),
    'rclpy.publisher': (
        'CallbackGroup Duration EventHandler MsgType PublisherEventCallbacks QoSProfile TypeVar Union _rclpy'
    ),
    'rclpy.qos': 'Duration Enum IntEnum Union _rclpy warnings',
    'rclpy.qos_overriding_options': (
        'Callable Duration Iterable List Optional Parameter ParameterAlreadyDeclaredException '
        'ParameterDescriptor Publisher QoSDurabilityPolicy QoSHistoryPolicy QoSLivelinessPolicy '
        'QoSPolicyKind QoSProfile QoSReliabilityPolicy QosCallbackResult SetParametersResult Subscription '
        'TYPE_CHECKING Text Type Union rclpy'
    ),
    'rclpy.serialization': '_rclpy check_for_type_support',
    'rclpy.service': (
        'Callable CallbackGroup Clock QoSProfile ServiceIntrospectionState SrvType SrvTypeRequest '
        'SrvTypeResponse TypeVar _rclpy'
    ),
    'rclpy.service_introspection': '_rclpy',
    'rclpy.signals': 'GuardCondition InvalidHandle _rclpy',
    'rclpy.subscription': (
        'Callable CallbackGroup Enum EventHandler MsgType QoSProfile SubscriptionEventCallbacks TypeVar '
        '_rclpy inspect'
    ),
    'rclpy.task': 'Callable Enum inspect sys threading warnings weakref',
    'rclpy.time': 'ClockType Duration Protocol S_TO_NS Tuple Union _rclpy builtin_interfaces',
    'rclpy.time_source': (
        'ClockType List Optional Parameter QoSProfile ROSClock ReliabilityPolicy Set SetParametersResult '
        'TYPE_CHECKING Time rosgraph_msgs weakref'
    ),
    'rclpy.timer': (
        'Callable CallbackGroup Clock Context InvalidHandle Optional ROSInterruptException _rclpy '
        'get_default_context threading'
    ),
    'rclpy.topic_endpoint_info': 'IntEnum QoSHistoryPolicy QoSPresetProfiles QoSProfile TypeHash',
    'rclpy.type_description_service': (
        'GetTypeDescription Parameter ParameterDescriptor ParameterType Service TOPIC_SEPARATOR_STRING '
        '_rclpy check_is_valid_srv_type qos_profile_services_default weakref'
    ),
    'rclpy.type_support': 'NoTypeSupportImportedException',
    'rclpy.utilities': 'Context List Optional S_TO_NS Sequence Set os sys threading',
    'rclpy.validate_full_topic_name': 'InvalidServiceNameException InvalidTopicNameException Literal _rclpy',
    'rclpy.validate_namespace': 'InvalidNamespaceException Literal _rclpy',
    'rclpy.validate_node_name': 'InvalidNodeNameException Literal _rclpy',
    'rclpy.validate_parameter_name': 'InvalidParameterException Literal',
    'rclpy.validate_topic_name': 'InvalidServiceNameException InvalidTopicNameException Literal _rclpy',
    'rclpy.wait_for_message': 'Node QoSProfile Union _rclpy timeout_sec_to_nsec',
}
"""The names that each module re-exports."""


def reexport(module: str) -> None:
    """Make the names of REEXPORTS available in a module of rclpy, beside the module's own names."""

    def find(name: str) -> object:
        if name not in REEXPORTS[module].split():
            raise AttributeError(f'module {module!r} has no attribute {name!r}')
        return _find(name)

    setattr(sys.modules[module], '__getattr__', find)  # noqa: B010 - type checkers must not see it


def _find(name: str) -> object:
    for origin, names in ORIGINS.items():
        for entry in names.split():
            alias, _, original = entry.partition('=')
            if alias == name:
                return getattr(import_module(origin), original or alias)
    return import_module(name)
