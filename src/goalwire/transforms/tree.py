"""The tree of frames: it stores each frame's parent, and computes the transform between two frames at a time.

Every method may be called on any thread.
"""

from __future__ import annotations

from math import isnan
from threading import Lock
from typing import NamedTuple

from goalwire.errors import (
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    RejectedTransform,
    peer_text,
)
from goalwire.transforms.history import LATEST, FixedLink, History, Link, seconds
from goalwire.transforms.rigid import (
    IDENTITY,
    Rigid,
    Vector,
    canonical,
    conjugate,
    difference,
    multiply,
    norm_squared,
    normalize,
    rotate,
    rotation_vector,
    scale,
)

NORM_TOLERANCE = 0.01  # tolerance of a quaternion's squared length, as in tf2


class Found(NamedTuple):
    """A transform between two frames, and the time at which it is valid."""

    motion: Rigid
    time: int


class Velocity(NamedTuple):
    """A linear velocity in m/s, and an angular velocity in rad/s as a vector along the axis."""

    linear: Vector
    angular: Vector


class FrameReport(NamedTuple):
    """The report of `frames` about one frame; times in ns."""

    name: str
    parent: str
    authority: str
    number: int
    newest: int
    oldest: int


class TransformTree:
    """The links between frames of the last `span` ns."""

    def __init__(self, span: int) -> None:
        self._span = span
        self._links: dict[str, History | FixedLink] = {}
        self._authorities: dict[str, str] = {}
        self._names: dict[str, None] = {}  # all frames that were ever named, in order of appearance
        self._lock = Lock()

    def clear(self) -> None:
        """Remove all links; the names of the frames stay known."""
        with self._lock:
            self._links.clear()

    def insert(
        self, parent: str, child: str, stamp: int, motion: Rigid, *, authority: str, static: bool
    ) -> None:
        """Store the pose of `child` in `parent`; a slash in front of a name is dropped.

        Raises RejectedTransform for bad names, a nan, a quaternion whose length is not 1, and data that is
        too old.
        """
        parent, child = parent.removeprefix('/'), child.removeprefix('/')
        _check(parent, child, motion, authority)
        link = Link(parent, Rigid(motion.translation, normalize(motion.rotation)))
        with self._lock:
            known = self._links.get(child)
            if known is None or isinstance(known, FixedLink) is not static:
                known = self._links[child] = FixedLink() if static else History(self._span)
            self._names.update({child: None, parent: None})
            if not known.insert(stamp, link):
                raise RejectedTransform(
                    f'TF_OLD_DATA ignoring data from the past for frame {child} at time {seconds(stamp)} '
                    f'according to authority {authority}: the newest is of {seconds(known.stamps[-1])}, '
                    f'kept are {self._span / 1e9:g} s'
                )
            self._authorities[child] = authority

    def lookup(self, target: str, source: str, time: int, caller: str = 'lookupTransform') -> Found:
        """Return the transform from `source` coordinates to `target` coordinates.

        LATEST stands for the newest time for which all moving links between the two frames have data. Raises
        InvalidArgumentException, LookupException, ConnectivityException or ExtrapolationException.
        """
        with self._lock:
            if target == source:
                return Found(IDENTITY, time or self._newest(target))
            self._check_known(target, f'{caller} argument target_frame')
            self._check_known(source, f'{caller} argument source_frame')
            if time == LATEST:
                time = self._latest_common_time(target, source)
            motion = self._motion(target, source, time)
            return Found(Rigid(motion.translation, canonical(motion.rotation)), time)

    def lookup_full(
        self,
        target: str,
        target_time: int,
        source: str,
        source_time: int,
        fixed: str,
        caller: str = 'lookupTransform',
    ) -> Found:
        """Return the transform from `source` at one time to `target` at another time, through `fixed`, which
        is taken to be the same at both.
        """
        with self._lock:
            for name, role in ((target, 'target'), (source, 'source'), (fixed, 'fixed')):
                self._check_known(name, f'{caller} argument {role}_frame')
        first = self.lookup(fixed, source, source_time, caller)
        second = self.lookup(target, fixed, target_time, caller)
        motion = second.motion.after(first.motion)
        return Found(Rigid(motion.translation, canonical(motion.rotation)), second.time)

    def latest_common_time(self, target: str, source: str, caller: str) -> int:
        """Return the newest time for which all moving links between two frames have data; LATEST if no link
        moves.
        """
        with self._lock:
            self._check_known(target, caller)
            self._check_known(source, caller)
            return self._newest(target) if target == source else self._latest_common_time(target, source)

    def velocity(
        self,
        tracked: str,
        observer: str,
        time: int,
        span: int,
        point: tuple[Vector, str] | None = None,
        axes: str | None = None,
    ) -> Velocity:
        """Return the velocity of `tracked` in `observer`, averaged over `span` ns around a time.

        `point` (coordinates, and the frame that they are in) is the point of `tracked` whose velocity is
        returned, by default its origin. `axes` is the frame in whose axes the velocity is returned, by
        default `observer`. The interval does not go beyond the newest known time. Raises what `lookup`
        raises; ValueError for a span of 0 or less.
        """
        if span <= 0:
            raise ValueError(f'a velocity needs an interval above 0 to be measured over, not {span} ns')
        newest = self.latest_common_time(tracked, observer, 'lookupVelocity')
        if newest == LATEST:
            return Velocity((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))  # a static frame, or the same frame
        end = newest if time == LATEST else min(time + span // 2, newest)
        start = max(end - span, 1)  # not 0, which stands for the latest time
        first, last = (self.lookup(observer, tracked, at).motion for at in (start, end))
        seconds_between = (end - start) / 1e9
        place = (0.0, 0.0, 0.0)
        if point is not None:
            place = self.lookup(tracked, point[1], end).motion.apply(point[0])
        linear = difference(last.apply(place), first.apply(place))
        turn = rotation_vector(multiply(last.rotation, conjugate(first.rotation)))
        if axes is not None:
            back = self.lookup(axes, observer, end).motion.rotation
            linear, turn = rotate(back, linear), rotate(back, turn)
        return Velocity(scale(linear, 1 / seconds_between), scale(turn, 1 / seconds_between))

    def names(self) -> list[str]:
        """Return all frames that were ever named, in the order of their appearance."""
        with self._lock:
            return list(self._names)

    def frames(self) -> list[FrameReport]:
        """Return a report of every frame that has a parent."""
        with self._lock:
            found = []
            for name in self._names:
                link = self._link(name, LATEST)
                if link is not None:
                    stamps = self._links[name].stamps
                    authority = self._authorities[name]
                    found.append(
                        FrameReport(name, link.parent, authority, len(stamps), stamps[-1], stamps[0])
                    )
            return found

    def _newest(self, frame: str) -> int:
        known = self._links.get(frame)
        return known.stamps[-1] if known is not None else LATEST

    def _link(self, frame: str, time: int) -> Link | None:
        known = self._links.get(frame)
        return known.at(time) if known is not None else None

    def _check_known(self, name: str, argument: str) -> None:
        if not name or name[0] == '/':
            reason = "start with a '/'" if name else 'be empty'
            raise InvalidArgumentException(
                f'Invalid argument "{name}" passed to {argument} - in tf2 frame_ids cannot {reason}'
            )
        if name not in self._names:
            raise LookupException(f'"{name}" passed to {argument} does not exist. ')

    def _motion(self, target: str, source: str, time: int) -> Rigid:
        """Return the transform from `source` to `target` by way of their common ancestor."""
        above: dict[str, Rigid] = {source: IDENTITY}  # the transform from `source` to each of its ancestors
        stopped: ExtrapolationException | None = None
        try:
            self._climb(above, source, time, until=(target,))
        except ExtrapolationException as error:  # both paths may meet below the missing data
            stopped = error
        mine: dict[str, Rigid] = {target: IDENTITY}
        try:
            meeting = self._climb(mine, target, time, until=above)
        except ExtrapolationException as error:
            raise _make_error(error, target, source) from None
        if meeting not in above:
            raise _describe_gap(target, source) if stopped is None else _make_error(stopped, target, source)
        return mine[meeting].inverse().after(above[meeting])

    def _climb(
        self, above: dict[str, Rigid], frame: str, time: int, until: dict[str, Rigid] | tuple[str]
    ) -> str:
        """Go up from `frame`, adding each ancestor to `above`; return the first frame in `until`, else the
        root.
        """
        while frame not in until:
            link = self._link(frame, time)
            if link is None:
                break
            if link.parent in above:
                raise self._loop(link.parent)
            above[link.parent] = link.motion.after(above[frame])
            frame = link.parent
        return frame

    def _latest_common_time(self, target: str, source: str) -> int:
        ways = self._ancestors(source), self._ancestors(target)
        shared = next((frame for frame in ways[0] if frame in ways[1]), None)
        if shared is None:
            raise _describe_gap(target, source)
        links = [frame for way in ways for frame in way[: way.index(shared)]]
        return min((time for time in map(self._newest, links) if time != LATEST), default=LATEST)

    def _ancestors(self, frame: str) -> list[str]:
        """Return a frame and its ancestors, following the newest links."""
        way = [frame]
        while link := self._link(way[-1], LATEST):
            if link.parent in way:
                raise self._loop(link.parent)
            way.append(link.parent)
        return way

    def _loop(self, frame: str) -> LookupException:
        return LookupException(
            f'The tf tree is invalid because it contains a loop: {peer_text(frame)} is its own ancestor. '
            'Each frame needs one parent, told by one broadcaster.'
        )


def _check(parent: str, child: str, motion: Rigid, authority: str) -> None:
    who = f'from authority "{authority}"'
    if not child:
        raise RejectedTransform(
            f'TF_NO_CHILD_FRAME_ID: Ignoring transform {who} because child_frame_id not set'
        )
    if not parent:
        raise RejectedTransform(
            f'TF_NO_FRAME_ID: Ignoring transform with child_frame_id "{child}" {who} because frame_id not set'
        )
    if child == parent:
        raise RejectedTransform(
            f'TF_SELF_TRANSFORM: Ignoring transform {who} with frame_id and child_frame_id "{child}" because '
            'they are the same'
        )
    if any(isnan(value) for value in (*motion.translation, *motion.rotation)):
        raise RejectedTransform(
            f'TF_NAN_INPUT: Ignoring transform for child_frame_id "{child}" {who} because of a nan value in '
            f'the transform {motion.translation} {motion.rotation}'
        )
    if not abs(norm_squared(motion.rotation) - 1) < NORM_TOLERANCE:
        raise RejectedTransform(
            f'TF_DENORMALIZED_QUATERNION: Ignoring transform for child_frame_id "{child}" {who} because of '
            f'an invalid quaternion in the transform {motion.rotation}'
        )


def _make_error(error: ExtrapolationException, target: str, source: str) -> ExtrapolationException:
    return ExtrapolationException(
        f'{error}, when looking up transform from frame [{source}] to frame [{target}]'
    )


def _describe_gap(target: str, source: str) -> ConnectivityException:
    return ConnectivityException(
        f"Could not find a connection between '{target}' and '{source}' because they are not part of the "
        'same tree. Tf has two or more unconnected trees.'
    )
