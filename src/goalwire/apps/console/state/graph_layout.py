"""Places nodes and topics in the drawing of the graph: linked ones are near each other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

Place: TypeAlias = tuple[float, float]

WIDTH, HEIGHT = 2.6, 1.0
_ROUNDS = 160
_FEW_ROUNDS = 40
_GOLDEN = 2.399963


def arrange(
    names: Sequence[str], links: Iterable[tuple[str, str]], before: Mapping[str, Place]
) -> dict[str, Place]:
    """Return a place for each name, within WIDTH and HEIGHT. A name that had a place stays near it.

    All names repel each other, and links attract (Fruchterman and Reingold, 1991), in ever smaller steps. The
    same graph always gets the same drawing.
    """
    if not names:
        return {}
    size = np.array([WIDTH, HEIGHT])
    number = {name: at for at, name in enumerate(names)}
    spiral = np.arange(len(names)) * _GOLDEN
    radius = np.sqrt((np.arange(len(names)) + 0.5) / len(names)) / 2
    places = (np.stack([np.cos(spiral), np.sin(spiral)], axis=1) * radius[:, None] + 0.5) * size
    known = [at for at, name in enumerate(names) if name in before]
    for at in known:
        places[at] = before[names[at]]
    joined = np.array([(number[one], number[other]) for one, other in links], dtype=int).reshape(-1, 2)
    reach = np.sqrt(WIDTH * HEIGHT / len(names))
    rounds = _FEW_ROUNDS if len(known) > len(names) / 2 else _ROUNDS
    for step in np.geomspace(0.1, 0.004, rounds) if rounds == _ROUNDS else np.geomspace(0.02, 0.004, rounds):
        apart = places[:, None, :] - places[None, :, :]
        distance = np.maximum(np.hypot(apart[..., 0], apart[..., 1]), 1e-3)
        force = (apart * (reach**2 / distance**2)[..., None]).sum(axis=1)
        pull = places[joined[:, 0]] - places[joined[:, 1]]
        pull *= (np.hypot(pull[:, 0], pull[:, 1]) / reach)[:, None]
        np.add.at(force, joined[:, 0], -pull)
        np.add.at(force, joined[:, 1], pull)
        force += (size / 2 - places) * 0.3
        length = np.maximum(np.hypot(force[:, 0], force[:, 1]), 1e-9)
        places += force / length[:, None] * np.minimum(length, step)[:, None]
        places = np.clip(places, 0.0, size)
    return {name: (float(places[at, 0]), float(places[at, 1])) for name, at in number.items()}
