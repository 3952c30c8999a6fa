"""The Robot view: the robot in 3D, with joints, frames, trail and target."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import nicegui
from nicegui import ui
from nicegui.element import Element

from goalwire.apps.console.page.balance_card import BalanceCard
from goalwire.apps.console.page.floor_goals import FloorGoals
from goalwire.apps.console.page.frames_card import FramesCard
from goalwire.apps.console.page.joints import JointSliders
from goalwire.apps.console.page.kept import keep_layout
from goalwire.apps.console.page.layers_card import LayersCard
from goalwire.apps.console.page.other_robots_card import OtherRobotsCard
from goalwire.apps.console.page.parts import head, hold_goal_lines
from goalwire.apps.console.page.scene_tools import SceneTools
from goalwire.apps.console.page.teleop_card import TeleopCard
from goalwire.apps.console.page.view import Page, View
from goalwire.apps.console.state.robot_model import scene_of
from goalwire.apps.console.state.series import put_sign
from goalwire.transforms.rigid import yaw_of

if TYPE_CHECKING:
    from goalwire.apps.console.state.draft import Draft
    from goalwire.apps.console.state.robot_model import RobotModel
    from goalwire.apps.console.state.robot_watch import RobotWatch

_THREE = Path(nicegui.__file__).parent / 'elements' / 'scene' / 'dist'
_NO_ROBOT = (
    'No robot yet: there is neither a robot_description nor joint states. A robot of yours needs a '
    'robot_state_publisher; `humanoid up` starts one that comes with goalwire.'
)


class RobotScene(
    Element,
    component='robot_scene.js',
    esm={'nicegui-scene': str(_THREE), 'goalwire-scene-layers': 'scene_layers'},
):
    """The 3D scene."""

    def begin(self, camera: list[float], *, follows: bool) -> None:
        """Choose the camera's place and the place that it looks at, before the browser makes the scene."""
        self.props['begin'] = camera
        self.props['follows'] = follows

    def set_dark(self, dark: bool) -> None:
        """Choose the colours."""
        self.props['dark'] = dark
        self.update()


class RobotView(View):
    """The scene, and beside it the robot's position, its targets, and its joints."""

    name = 'robot'
    title = 'Robot'
    icon = 'smart_toy'
    period = 1 / 15

    def __init__(self, page: Page) -> None:
        super().__init__(page)
        self._watch: RobotWatch | None = None
        self._version = -1
        self._model: RobotModel | None = None
        self._mesh_problem = ''
        self._meshes_version = 0
        self._names: list[str] = []
        self._sent: object = None
        self._seen: object = None
        self._refused = ''
        self._joints: JointSliders | None = None

    def build(self) -> None:
        with ui.element('div').classes('gw-fill gw-robot-view'):
            with ui.element('div').classes('gw-card flush').style('position: relative; min-height: 400px'):
                self._scene = RobotScene().style('position: absolute; inset: 0')
                self._scene.begin(self.page.layout.camera, follows=self.page.layout.follows)
                self._scene.set_dark(self.page.is_dark)
                self._scene.on('floor', self._on_floor)
                self._scene.on('pose', self._on_pose)
                self._build_bar()
            with ui.element('div').classes('gw-stack').style('overflow: auto'):
                self._build_state()
                self._teleop = TeleopCard(self.page)
                self._balance = BalanceCard(self.page)
                self._frames = FramesCard(self.page, self._scene)
                self._layers = LayersCard(self.page, self._scene)
                self._others = OtherRobotsCard(self.page, self._scene)
                self._joint_card = ui.element('div').classes('gw-card').props('data-joints')
                self._joint_card.set_visibility(False)
                hold_goal_lines(self._goal_lines, under=self._joint_card)

    def _build_bar(self) -> None:
        with ui.element('div').classes('gw-scene-foot'):
            self._foot = ui.label('').classes('gw-float gw-mono')
            hint = ui.label('').classes('gw-float').props('data-hint')
        with ui.element('div').classes('gw-scene-bar'):
            _build_camera_buttons(self.page, self._scene)
            self._tools = SceneTools(self.page, self._scene, hint)

    def _build_state(self) -> None:
        with ui.element('div').classes('gw-card'):
            with head('Robot', 'smart_toy'):
                ui.element('div').classes('gw-spread')
                self._fresh = ui.label('').classes('gw-chip').props('data-fresh')
            self._about = ui.label('').classes('gw-small gw-dim')
            self._gone = ui.label('').classes('gw-note').props('data-gone')
            self._gone.set_visibility(False)
            self._problem = ui.label('').classes('gw-problem').props('data-robot-problem')
            self._problem.set_visibility(False)
            self._floor_goals = FloorGoals(self)
            self._goal_lines = ui.element('div').classes('gw-goal-lines').props('data-goal-lines')

    def set_dark(self, dark: bool) -> None:
        self._scene.set_dark(dark)

    # -- the selected robot ----------------------------------------------------------------------------------

    def _look_at_graph(self) -> None:
        seen = (self.node.graph.version, self.page.robot, frozenset(self.session.vitals))
        if seen == self._seen:
            return
        self._seen = seen
        self._names = self.session.robot_names()
        is_there = self.page.robot in self._names
        if (self._watch is None and is_there) or (
            self._watch is not None and self._watch.namespace != self.page.robot
        ):
            self._follow(self.page.robot)
        click_text = self._floor_goals.look(self._whom())
        self._tools.look(self.page.robot, click_text=click_text)
        self._teleop.look(self.page.robot)
        self._balance.look(self.page.robot)
        self._layers.look(self.page.robot)
        self._others.look(self.page.robot, self._names)
        if self._joints is not None:
            self._joints.look()

    def _whom(self) -> str:
        """Return the selected robot's name on the page: its namespace if there are several robots."""
        return 'it' if len(self.session.vitals) == 1 else self.page.robot or '/'

    def _follow(self, namespace: str) -> None:
        if self._watch is not None:
            self.session.leave_robot(self._watch)
            self._watch = None
        self._refused = self.rights.why_not_watch(namespace)
        if self._refused:
            return
        self._watch = self.session.watch_robot(namespace)
        self._version = -1

    # -- refreshing the view ---------------------------------------------------------------------------------

    def refresh(self) -> None:
        self._look_at_graph()
        watch = self._watch
        if watch is None:
            self._about.set_text(self._refused or _NO_ROBOT)
            self._fresh.set_visibility(False)
            self._foot.set_visibility(False)
            return
        if watch.version != self._version or self._meshes_version != self.session.meshes.version:
            self._version = watch.version
            self._take_model(watch)
        frame, base = watch.pose()
        x, y, z = base.translation
        yaw = yaw_of(base.rotation)
        links = watch.link_poses()
        marks = self._floor_goals.marks(watch)
        self._frames.refresh(watch)
        state = (links, marks, len(watch.trail))
        if state != self._sent:
            update: dict[str, Any] = {'links': links, 'base': [x, y, z], 'goals': marks}
            update['trail'] = [[round(px, 3), round(py, 3)] for px, py, _ in watch.trail]
            self._sent = state
            self._scene.run_method('frame', update)
        self._balance.refresh(watch)
        self._layers.refresh(watch)
        self._others.refresh(watch)
        self._foot.set_visibility(True)
        self._foot.set_text(f'{frame or "?"}  x {put_sign(x)}  y {put_sign(y)} m  {math.degrees(yaw):+.0f}°')
        self._fresh.set_visibility(True)
        self._put_state(watch)
        if self._joints is not None:
            self._joints.refresh(watch.positions)
        self._put_goals()

    def _put_state(self, watch: RobotWatch) -> None:
        """Show the age of the latest data; a robot that is silent or gone stays in its place, in grey."""
        is_there = watch.namespace in self._names
        is_fresh = watch.is_fresh and is_there
        has_moved = watch.moved_at is not None
        news = 'live' if is_fresh else f'no news for {watch.age:.0f} s' if has_moved else 'no news yet'
        self._fresh.set_text(news)
        self._fresh.classes(add='good' if is_fresh else 'warn', remove='warn' if is_fresh else 'good')
        is_old = has_moved and not is_fresh
        self._scene.classes(add='gw-stale') if is_old else self._scene.classes(remove='gw-stale')
        self._gone.set_visibility(is_old)
        if is_old:
            self._gone.set_text(f'It {"is silent" if is_there else "has gone"}: shown is where it was.')

    def _take_model(self, watch: RobotWatch) -> None:
        model, version = watch.model, self.session.meshes.version
        if model is None or model is not self._model:
            self._model, self._mesh_problem = model, ''
            self._draw_model(model)
        elif self._meshes_version != version:
            self._draw_shapes(model)
        self._meshes_version = version
        problem = watch.problem or self._mesh_problem
        self._problem.set_visibility(bool(problem))
        self._problem.set_text(problem)

    def _draw_model(self, model: RobotModel | None) -> None:
        self._joint_card.clear()
        self._joint_card.set_visibility(model is not None)
        self._joints = None
        if model is None:
            self._about.set_text('Its robot_description has not come yet.')
            self._scene.run_method('set_model', [])
            self._sent = None
            return
        self._draw_shapes(model)
        with self._joint_card:
            self._joints = JointSliders(self, list(model.kinematics.joints))

    def _draw_shapes(self, model: RobotModel) -> None:
        self._sent = None
        scene, self._mesh_problem, missing = scene_of(model, self.session.meshes)
        self._about.set_text(_describe(model, missing))
        self._scene.run_method('set_model', scene)

    def _put_goals(self) -> None:
        goals = self.rights.of_seen_actions(goal for goal in self.session.goals.active() if goal.is_mine)[-3:]
        state = [goal.goal_id for goal in goals]
        if state != getattr(self, '_goal_state', None):
            self._goal_state = state
            self._goal_lines.clear()
            self._goal_bars: dict[str, Any] = {}
            with self._goal_lines:
                for goal in goals:
                    with ui.element('div').classes('gw-group').style('gap: 5px'):
                        with ui.element('div').classes('gw-head'):
                            ui.label(goal.action).classes('gw-mono')
                            ui.element('div').classes('gw-spread')
                            ui.button(
                                'Cancel', on_click=lambda goal=goal: self._cancel(goal.action, goal.goal_id)
                            ).props('flat dense no-caps size=sm color=negative data-cancel')
                        with ui.element('div').classes('gw-bar'):
                            self._goal_bars[goal.goal_id] = ui.element('div').style('width: 0')
        for goal in goals:
            self._goal_bars[goal.goal_id].style(f'width: {(goal.progress or 0.0) * 100:.0f}%')

    async def _cancel(self, action: str, goal_id: str) -> None:
        if await self.page.attempt(self.session.sender.cancel(action, self.rights, goal_id)) is not None:
            self.page.tell('The goal is being cancelled')

    # -- presses on the floor ------------------------------------------------------------------------------

    async def _on_floor(self, event: Any) -> None:
        self._tools.choose('')
        if self._watch is not None:
            x, y, yaw = _place_of(event)
            await self._floor_goals.offer(self._watch, x, y, yaw)

    async def _on_pose(self, event: Any) -> None:
        if self._watch is None:
            return
        x, y, yaw = _place_of(event)
        frame, base = self._watch.pose()
        turn = yaw_of(base.rotation) if yaw is None else yaw  # without a drag it faces as before
        await self._tools.send_initial_pose(frame, x, y, turn)

    def resume(self, draft: Draft) -> bool:
        return self._floor_goals.resume(draft)

    def close(self) -> None:
        self._teleop.close()
        self._balance.close()
        self._layers.close()
        self._others.close()
        if self._watch is not None:
            self.session.leave_robot(self._watch)
            self._watch = None


def _describe(model: RobotModel, missing: int) -> str:
    """Return a line about a model of which so many meshes cannot be shown."""
    movable = sum(joint.is_free for joint in model.kinematics.joints)
    links = len(model.kinematics.links)
    hidden = f'; {missing} meshes are not shown' if missing else ''
    return f'{model.kinematics.name}: {links} links, {movable} joints that move{hidden}'


def _build_camera_buttons(page: Page, scene: RobotScene) -> None:
    """Add the buttons that turn the camera; the page's layout keeps where the camera is."""

    def set_follow(event: Any) -> None:
        page.layout.follows = bool(event.value)
        keep_layout(page)
        scene.run_method('set_follow', bool(event.value))

    def on_camera(event: Any) -> None:
        places = event.args
        if isinstance(places, list) and len(places) == 6 and all(isinstance(n, int | float) for n in places):
            page.layout.camera = [float(each) for each in places]
            keep_layout(page)

    scene.on('camera', on_camera)
    for way, icon in (
        ('free', '3d_rotation'),
        ('front', 'face'),
        ('side', 'switch_left'),
        ('top', 'vertical_align_bottom'),
    ):
        ui.button(icon=icon, on_click=lambda way=way: scene.run_method('view_from', way)).props(
            f'flat dense round size=sm aria-label="View: {way}"'
        ).classes('gw-float').tooltip(f'View: {way}')
    follow = ui.checkbox('Follow', value=page.layout.follows, on_change=set_follow)
    follow.props('dense size=sm data-follow').classes('gw-float')


def _place_of(event: Any) -> tuple[float, float, float | None]:
    """Return the place of a press on the floor, to the centimetre, and its heading, if a drag gave one."""
    x, y = (round(float(event.args[name]), 2) + 0.0 for name in 'xy')
    yaw = event.args.get('yaw')
    return x, y, None if yaw is None else float(yaw)
