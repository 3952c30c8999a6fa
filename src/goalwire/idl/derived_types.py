"""The types that ROS 2 derives from a .srv or .action, such as the SendGoal service of an action."""

from __future__ import annotations

from goalwire.idl.model import (
    ActionDefinition,
    Field,
    FieldType,
    MessageDefinition,
    ServiceDefinition,
    Shape,
)

_UUID = FieldType('unique_identifier_msgs/msg/UUID')
_TIME = FieldType('builtin_interfaces/msg/Time')
_EVENT_INFO = FieldType('service_msgs/msg/ServiceEventInfo')
CANCEL_SERVICE = 'action_msgs/srv/CancelGoal'
STATUS_MESSAGE = 'action_msgs/msg/GoalStatusArray'


def service(request: MessageDefinition, response: MessageDefinition) -> ServiceDefinition:
    """Make the service X from X_Request and X_Response, and add X_Event."""
    name = request.name.removesuffix('_Request')
    event = MessageDefinition(
        request.package,
        request.kind,
        f'{name}_Event',
        (
            Field('info', _EVENT_INFO),
            Field('request', FieldType(request.full_name, Shape.BOUNDED, 1)),
            Field('response', FieldType(response.full_name, Shape.BOUNDED, 1)),
        ),
        source=request.source,
    )
    return ServiceDefinition(request.package, request.kind, name, request, response, event)


def action(
    goal: MessageDefinition, result: MessageDefinition, feedback: MessageDefinition
) -> ActionDefinition:
    """Make the action X from X_Goal, X_Result and X_Feedback, and add its services and feedback message."""
    package, kind, source = goal.package, goal.kind, goal.source
    name = goal.name.removesuffix('_Goal')

    def message(suffix: str, *fields: Field) -> MessageDefinition:
        return MessageDefinition(package, kind, f'{name}_{suffix}', fields, source=source)

    goal_id = Field('goal_id', _UUID)
    return ActionDefinition(
        package,
        kind,
        name,
        goal,
        result,
        feedback,
        service(
            message('SendGoal_Request', goal_id, Field('goal', FieldType(goal.full_name))),
            message('SendGoal_Response', Field('accepted', FieldType('bool')), Field('stamp', _TIME)),
        ),
        service(
            message('GetResult_Request', goal_id),
            message(
                'GetResult_Response',
                Field('status', FieldType('int8')),
                Field('result', FieldType(result.full_name)),
            ),
        ),
        message('FeedbackMessage', goal_id, Field('feedback', FieldType(feedback.full_name))),
    )
