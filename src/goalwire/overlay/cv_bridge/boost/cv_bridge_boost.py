"""The functions of cv_bridge's compiled part in Python, in a module of the same name."""

from __future__ import annotations

from cv_bridge.conversion import Picture, convert
from cv_bridge.display import cvtColorForDisplay
from cv_bridge.encodings import DEPTHS, depth_and_channels, getCvType

__all__ = ['CV_MAT_CNWrap', 'CV_MAT_DEPTHWrap', 'cvtColor2', 'cvtColorForDisplay', 'getCvType']


def CV_MAT_CNWrap(i: int) -> int:
    """Return how many channels an OpenCV type has."""
    return depth_and_channels(i)[1]


def CV_MAT_DEPTHWrap(i: int) -> int:
    """Return OpenCV's number for the depth of a type."""
    return DEPTHS.index(depth_and_channels(i)[0])


def cvtColor2(image: Picture, encoding_in: str, encoding_out: str) -> Picture:
    """Return a picture in another encoding; raises RuntimeError if it cannot be converted."""
    return convert(image, encoding_in, encoding_out)
