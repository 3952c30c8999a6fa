"""The page of a recording: a timeline, and the robot, messages, plots and log lines of a time on it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fastapi import FastAPI
from nicegui import Client, background_tasks, ui

from goalwire.apps.console.page.connection import install_watch, watch_connection
from goalwire.apps.console.page.kept import ask_for_kept, keep_dark
from goalwire.apps.console.page.logs_view import COLUMNS, log_row
from goalwire.apps.console.page.pacing import Pacer
from goalwire.apps.console.page.parts import LiveTable, SwimLanes, ValueTree, head, lane_groups
from goalwire.apps.console.page.recording_plots import RecordingPlots
from goalwire.apps.console.page.robot_view import RobotScene
from goalwire.apps.console.page.site import install_site
from goalwire.apps.console.page.theme import set_colours
from goalwire.apps.console.state.meshes import Meshes
from goalwire.apps.console.state.playhead import Playhead
from goalwire.apps.console.state.recorded_moment import Moment, Moments
from goalwire.apps.console.state.robot_model import scene_of
from goalwire.apps.console.state.series import put_sign
from goalwire.errors import RemoteError
from goalwire.idl.pictures import COMPRESSED, IMAGE, as_data_url
from goalwire.logging.record import local_date_time
from goalwire.observe.messages import as_data

if TYPE_CHECKING:
    from goalwire.apps.console.state.recording import Recording
    from goalwire.observe.goals import GoalTable

_PERIOD_S = 1 / 15
_RATES = (0.1, 0.25, 0.5, 1.0, 2.0, 5.0, 10.0, 50.0)
_STEP_NS, _FAR_NS = 100_000_000, 5_000_000_000
_SILENT_S = 2.0
"""Seconds without a message after which the robot is shown in grey, as in the live view."""


@contextmanager
def install(application: FastAPI, recording: Recording, goals: GoalTable) -> Iterator[None]:
    """Add the page of a recording to an application until the block ends. Only once in a process."""
    meshes, pages = Meshes(), list[RecordingPage]()
    install_watch(application)
    style = install_site(application, meshes)

    @ui.page('/')
    def page() -> None:
        pages[:] = [each for each in pages if not each.closed]
        pages.append(RecordingPage(ui.context.client, recording, goals, meshes))
        pages[-1].build(style)

    try:
        yield
    finally:
        for each in pages:
            each.close()


class RecordingPage:
    """One browser's page, with a position in the recording of its own."""

    def __init__(self, client: Client, recording: Recording, goals: GoalTable, meshes: Meshes) -> None:
        self.closed = False
        self._client = client
        self._recording = recording
        self._goals = goals
        self._meshes = meshes
        self._playhead = Playhead(recording.start, recording.end)
        self._pacer = Pacer(client, self._refresh)
        self._moments = Moments(recording, self._pacer.refresh_soon)
        self._robot = recording.robots[0] if recording.robots else None
        self._topic = ''
        self._wanted: object = None
        self._shown: Moment | None = None
        self._drawn: tuple[object, int] = None, 0
        """The model that is in the scene, and the version of the meshes that it was drawn with."""
        self._scene_sent: object = None
        self._is_dark = False

    # -- elements --------------------------------------------------------------------------------------------

    def build(self, style: str) -> None:
        """Make the page and begin to refresh it; `style` is the address of the style sheet."""
        ui.add_head_html(f'<link rel="stylesheet" href="{style}">')
        watch_connection('The recording goes on when the console is there again.')
        self._dark = ui.dark_mode(value=None)
        set_colours()
        with ui.element('div').classes('gw-shell gw-player'):
            with ui.element('header').classes('gw-top'):
                self._build_bar()
            with ui.element('main').classes('gw-main'):
                self._build_main()
            with ui.element('footer').classes('gw-card gw-transport'):
                self._build_transport()
        self._client.on_delete(self.close)
        background_tasks.create(self._begin())

    async def _begin(self) -> None:
        kept = await ask_for_kept(self._client)
        with self._client:
            self._set_dark(kept.is_dark)
            self._put_lanes()
            self._put_topics()
        await self._pacer.run()

    def _build_bar(self) -> None:
        ui.element('span').classes('gw-brand-mark')
        ui.label('goalwire console').classes('gw-brand')
        with ui.element('div').classes('gw-recorded').props('data-recording role=status'):
            ui.icon('history', size='18px')
            ui.label('Recording').classes('gw-recorded-title')
            ui.label('This is not live, and nothing can be sent from here.')
        ui.element('div').classes('gw-spread')
        ui.label(Path(self._recording.path).resolve().name).classes('gw-chip gw-mono').tooltip(
            self._recording.path
        )
        self._theme = ui.button(icon='dark_mode', on_click=self._switch_dark).props(
            'flat dense round size=sm data-theme aria-label="Dark or light"'
        )

    def _build_main(self) -> None:
        self._problems = ui.label('').classes('gw-problem').props('data-problems')
        self._problems.set_visibility(False)
        with ui.element('div').classes('gw-recorded-view'):
            with ui.element('div').classes('gw-card flush gw-recorded-scene'):
                self._scene = RobotScene().style('position: absolute; inset: 0')
                with ui.element('div').classes('gw-scene-bar'):
                    if len(self._recording.robots) > 1:
                        ui.select(
                            {name: name or '/' for name in self._recording.robots},
                            value=self._robot,
                            on_change=self._choose_robot,
                        ).props('outlined dense options-dense data-robot').classes('gw-robot')
                    self._fresh = ui.label('').classes('gw-chip warn').props('data-silent')
                with ui.element('div').classes('gw-scene-foot'):
                    self._foot = ui.label('').classes('gw-float gw-mono').props('data-pose')
            with ui.element('div').classes('gw-stack'):
                self._build_topics()
        self._plots = RecordingPlots(self._recording, self._pacer.refresh_soon)
        with ui.element('div').classes('gw-card flush').props('data-log'):
            with head('Logs', 'subject'):
                ui.label('up to this time').classes('gw-dim gw-small')
            with ui.element('div').style('max-height: 40vh; overflow: auto; width: 100%'):
                self._lines = LiveTable(COLUMNS, empty='No line was recorded by then.')

    def _build_topics(self) -> None:
        with ui.element('div').classes('gw-card flush').style('max-height: 300px'):
            head('Topics', 'podcasts')
            self._table = LiveTable(
                [
                    {'name': 'name', 'label': 'Topic', 'mono': True, 'clip': True},
                    {'name': 'type', 'label': 'Type', 'mono': True, 'clip': True},
                    {'name': 'count', 'label': 'Messages', 'align': 'right', 'width': '84px'},
                ],
                empty='',
                on_row=self._choose_topic,
            )
        with ui.element('div').classes('gw-card').style('max-height: 420px; overflow: auto'):
            with ui.element('div').classes('gw-head'):
                self._topic_name = ui.label('Choose a topic to see its message at this time.')
                self._topic_name.classes('gw-title gw-mono')
                ui.element('div').classes('gw-spread')
                self._topic_time = ui.label('').classes('gw-dim gw-small').props('data-message-time')
            self._picture = ui.image().classes('gw-picture').props('no-spinner no-transition fit=contain')
            self._picture.set_visibility(False)
            self._tree = ValueTree(empty='', on_plot=lambda path: self._plots.add(self._topic, path))

    def _build_transport(self) -> None:
        with ui.element('div').classes('gw-head gw-transport-bar'):
            for name, icon, text in (
                ('start', 'skip_previous', 'To the start (Home)'),
                ('back', 'chevron_left', 'Back 0.1 s (arrow left; with Shift 5 s)'),
                ('play', 'play_arrow', 'Play or pause (space)'),
                ('on', 'chevron_right', 'On 0.1 s (arrow right; with Shift 5 s)'),
                ('end', 'skip_next', 'To the end (End)'),
            ):
                button = ui.button(icon=icon, on_click=lambda name=name: self._on_key(name)).props(
                    f'flat dense round data-{name} aria-label="{text}"'
                )
                button.tooltip(text)
                if name == 'play':
                    self._play = button
            self._rate = ui.select(
                {rate: f'{rate:g}x' for rate in _RATES}, value=1.0, on_change=self._set_rate
            ).props('outlined dense options-dense data-rate aria-label="Rate"')
            self._rate.style('width: 84px')
            self._clock = ui.label('').classes('gw-mono').props('data-time')
            ui.element('div').classes('gw-spread')
            self._about = ui.label('').classes('gw-small gw-dim')
        with ui.element('div').style('max-height: 26vh; overflow: auto; width: 100%'):
            self._lanes = SwimLanes(on_seek=self._seek_to, on_key=self._on_key).props('data-timeline')

    # -- the user's commands ---------------------------------------------------------------------------------

    def _seek_to(self, seconds: float) -> None:
        if math.isfinite(seconds):
            self._playhead.seek(self._recording.start + int(seconds * 1e9))
            self._pacer.refresh_soon()

    def _on_key(self, name: str) -> None:
        playhead = self._playhead
        steps = {'back': -_STEP_NS, 'on': _STEP_NS, 'far-back': -_FAR_NS, 'far-on': _FAR_NS}
        if name in steps:
            playhead.step(steps[name])
        elif name == 'play':
            playhead.pause() if playhead.is_playing else playhead.play()
        elif name in {'start', 'end'}:
            playhead.seek(playhead.start if name == 'start' else playhead.end)
        elif name in {'faster', 'slower'}:
            at = _RATES.index(playhead.rate) + (1 if name == 'faster' else -1)
            self._rate.set_value(_RATES[min(max(at, 0), len(_RATES) - 1)])
        self._pacer.refresh_soon()

    def _set_rate(self, event: Any) -> None:
        if event.value in _RATES:
            self._playhead.set_rate(float(event.value))

    def _choose_robot(self, event: Any) -> None:
        if event.value in self._recording.robots:
            self._robot = event.value
            self._pacer.refresh_soon()

    def _choose_topic(self, name: str) -> None:
        topic = self._recording.topics.get(name)
        if topic is not None:
            self._topic = name
            self._table.choose(name)
            self._topic_name.set_text(name)
            self._picture.set_visibility(topic.type_name in {IMAGE, COMPRESSED})
            self._pacer.refresh_soon()

    # -- refreshing the page ---------------------------------------------------------------------------------

    def _put_lanes(self) -> None:
        duration = max(self._recording.duration, 0.001)
        goals = list(self._goals)
        groups = lane_groups(goals, duration, duration * 0.14)
        self._lanes.put({'now': duration, 'span': duration, 'groups': groups})
        total = sum(self._recording.counts.values())
        self._about.set_text(
            f'{total:,} messages' + (f', {len(goals)} goal{"s" * (len(goals) > 1)}' if goals else '')
        )

    def _put_topics(self) -> None:
        counts = self._recording.counts
        self._table.put(
            [
                {
                    'key': topic.name,
                    'cells': [
                        {'text': topic.name, 'title': topic.name},
                        {'text': topic.type_name.replace('/msg/', '/'), 'title': topic.type_name},
                        {'text': f'{counts[topic.name]:,}', 'sort': counts[topic.name]},
                    ],
                }
                for topic in sorted(self._recording.topics.values(), key=lambda topic: topic.name)
            ]
        )

    def _refresh(self) -> float:
        time = self._playhead.time
        wanted = (time, self._robot, self._topic)
        if wanted != self._wanted:
            self._wanted = wanted
            self._moments.want(*wanted)
            seconds = self._recording.seconds(time)
            self._lanes.put_cursor(seconds)
            self._clock.set_text(
                f'{seconds:.2f} s of {self._recording.duration:.2f} s · {local_date_time(time)}'
            )
        self._play.props(f'icon={"pause" if self._playhead.is_playing else "play_arrow"}')
        moment = self._moments.latest
        if moment is not None and moment is not self._shown:
            self._shown = moment
            self._put_moment(moment)
        self._plots.refresh(time)
        return _PERIOD_S if self._playhead.is_playing else 0.5

    def _put_moment(self, moment: Moment) -> None:
        self._put_robot(moment)
        self._lines.put([log_row(line) for line in moment.lines])
        if moment.topic == self._topic and moment.topic:
            self._put_message(moment)
        problems = list(dict.fromkeys((*self._recording.problems, *moment.problems)))[:5]
        self._problems.set_visibility(bool(problems))
        self._problems.set_text('\n'.join(problems))

    def _put_robot(self, moment: Moment) -> None:
        if self._drawn != (drawn := (moment.model, self._meshes.version)):
            self._drawn = drawn
            scene = [] if moment.model is None else scene_of(moment.model, self._meshes)[0]
            self._scene.run_method('set_model', scene)
            self._scene_sent = None
        base = moment.base
        if base is not None:
            x, y, z = base.translation
            update = {
                'links': moment.links,
                'base': [x, y, z],
                'goals': [],
                'trail': [[round(px, 3), round(py, 3)] for px, py, _ in moment.trail],
            }
            if update != self._scene_sent:
                self._scene_sent = update
                self._scene.run_method('frame', update)
        silent = moment.silent_s
        is_old = silent is not None and silent > _SILENT_S
        self._scene.classes(add='gw-stale') if is_old else self._scene.classes(remove='gw-stale')
        self._fresh.set_visibility(is_old or silent is None)
        self._fresh.set_text(
            'no news of a robot yet' if silent is None else f'no news for {silent:.0f} s at this time'
        )
        self._foot.set_visibility(base is not None and silent is not None)
        if base is not None:
            east, north = map(put_sign, base.translation[:2])
            self._foot.set_text(f'{moment.frame or "?"}  x {east}  y {north} m')

    def _put_message(self, moment: Moment) -> None:
        if moment.message is None:
            self._tree.put({})
            self._topic_time.set_text('none by this time')
            return
        self._tree.put(as_data(moment.message))
        self._topic_time.set_text(f'at {self._recording.seconds(moment.message_time):.3f} s')
        if self._recording.topics[moment.topic].type_name in {IMAGE, COMPRESSED}:
            try:
                self._picture.set_source(as_data_url(moment.message))
            except RemoteError as error:
                self._topic_time.set_text(str(error))

    # -- light and dark --------------------------------------------------------------------------------------

    def _switch_dark(self) -> None:
        self._set_dark(not self._is_dark)
        keep_dark(self._client, dark=self._is_dark)

    def _set_dark(self, dark: bool) -> None:
        self._is_dark = dark
        self._dark.set_value(dark)
        self._theme.props(f'icon={"light_mode" if dark else "dark_mode"}')
        self._scene.set_dark(dark)
        self._lanes.set_dark(dark)
        self._plots.set_dark(dark)

    def close(self) -> None:
        """Close the page, after the browser has left or the console ends. Idempotent."""
        if self.closed:
            return
        self.closed = True
        self._pacer.close()
        self._moments.close()
        self._plots.close()
