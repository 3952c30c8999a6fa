"""An errand of the humanoid that outlives its program: kill it, start it again, and it goes on where it was.

humanoid up
goalwire mission run examples/missions/errand.py:errand --id errand-1
"""

from __future__ import annotations

from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from humanoid_interfaces.action import MoveArm, MoveToPosition
from humanoid_interfaces.srv import GetBatteryStatus
from std_msgs.msg import Header

from goalwire.missions import Steps, mission

HOME = (0.0, 0.0)
TABLE = (1.2, 0.9)
UP = {'left_arm_shoulder': 1.5, 'left_arm_elbow': 1.0}
DOWN = {'left_arm_shoulder': 0.5, 'left_arm_elbow': 0.0}
LEAST_CHARGE = 0.2


@mission(version=1, timeout=600.0)
async def errand(m: Steps) -> str:
    """Drive to the table, reach for what lies there, and bring it home."""
    # Both actions name absolute targets. So a goal that may have run is sent again without a question.
    drive = m.action(MoveToPosition, 'move_to_position', if_lost='again')
    arm = m.action(MoveArm, 'move_arm', if_lost='again')
    battery = m.client(GetBatteryStatus, 'get_battery_status', idempotent=True)

    # Retries with limits, as exercise 4 asks for them: each attempt and its pause is in the journal.
    status = await battery.call(timeout=1.0, attempts=10, pause=0.5)
    if status.battery.percentage < LEAST_CHARGE:
        m.give_up(f'a charge of {status.battery.percentage:.0%} is too low')

    async with m.undo() as undo:
        undo.push(drive.call, to(HOME), timeout=60.0)  # if what follows fails
        await drive.call(to(TABLE), timeout=60.0)
        undo.push(arm.call, reach(DOWN), timeout=30.0)
        await arm.call(reach(UP), timeout=30.0)
        await arm.call(reach(DOWN), timeout=30.0)
        await drive.call(to(HOME), timeout=60.0)
    return 'brought home'


def to(place: tuple[float, float]) -> MoveToPosition.Goal:
    """Return the goal to drive to a place, in m from where the robot started."""
    x, y = place
    pose = Pose(position=Point(x=x, y=y), orientation=Quaternion(w=1.0))
    return MoveToPosition.Goal(
        target_pose=PoseStamped(header=Header(frame_id='odom'), pose=pose), timeout=50.0
    )


def reach(joints: dict[str, float]) -> MoveArm.Goal:
    """Return the goal to move joints to angles in rad."""
    return MoveArm.Goal(joint_names=list(joints), positions=list(joints.values()), duration=1.5)
