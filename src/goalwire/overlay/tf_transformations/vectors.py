"""Lengths and directions."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]


def floats(data: ArrayLike) -> Array:
    """Return the data as an array of floats."""
    return np.asarray(data, dtype=np.float64)


def vector_norm(data: ArrayLike, axis: int | None = None, out: Array | None = None) -> Array | float:
    """Return the length of a vector, or the lengths along `axis`; with `out`, write them to `out`."""
    lengths = np.sqrt(np.sum(floats(data) ** 2, axis=axis))
    if out is None:
        return float(lengths) if np.ndim(lengths) == 0 else floats(lengths)
    out[...] = lengths
    return out


def unit_vector(data: ArrayLike, axis: int | None = None, out: Array | None = None) -> Array:
    """Return the vector, or the vectors along `axis`, scaled to length 1; with `out`, write them to `out`."""
    vectors = floats(data)
    lengths = np.sqrt(np.sum(vectors**2, axis=axis, keepdims=axis is not None))
    units: Array = vectors / lengths
    if out is None:
        return units
    out[...] = units
    return out


def random_vector(size: int | tuple[int, ...]) -> Array:
    """Return random numbers from [0, 1) in an array of shape `size`."""
    return np.random.default_rng().random(size)
