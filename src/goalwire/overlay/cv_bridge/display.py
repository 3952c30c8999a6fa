"""Makes pictures for display: labels as colours, depths as shades of gray. The rules are cv_bridge's."""

from __future__ import annotations

from functools import cache

import numpy as np

from cv_bridge.conversion import Picture, convert, require_opencv
from cv_bridge.encodings import ConversionError, encoding_of

_PLAIN = {
    '8UC1': 'mono8',
    '16UC1': 'mono16',
    '8UC3': 'bgr8',
    '8UC4': 'bgra8',
    '16UC3': 'bgr16',
    '16UC4': 'bgra16',
}
"""The encodings assumed for pictures that do not name their channels."""


def cvtColorForDisplay(
    source: Picture,
    encoding_in: str,
    encoding_out: str = '',
    do_dynamic_scaling: bool = False,
    min_image_value: float = 0.0,
    max_image_value: float = 0.0,
    colormap: int = -1,
) -> Picture:
    """Return a picture of 8 bits that a screen can show; '' for `encoding_out` means bgr8.

    Each label (32SC1) gets a colour; label 0 is black. Other values are scaled so that `min_image_value`
    becomes 0 and `max_image_value` 255; `do_dynamic_scaling` takes these bounds from the picture. `colormap`
    is one of OpenCV's color maps. Raises RuntimeError if the picture cannot be converted.
    """
    target = encoding_of(encoding_out or 'bgr8')
    if target.kind not in {'gray', 'rgb', 'bgr', 'rgba', 'bgra'} or target.bits != 8:
        raise ConversionError(
            f'[{target.name}] cannot be shown: choose mono8, bgr8 or another color of 8 bits'
        )
    if target.name == 'bgr8' and encoding_in == '32SC1':
        return _labels(source)
    if do_dynamic_scaling:
        known = source[np.isfinite(source)]
        if not known.size or known.min() == known.max():
            return np.full((*source.shape[:2], target.channels), 127, np.uint8).squeeze()
        min_image_value, max_image_value = float(known.min()), float(known.max())
    if min_image_value != max_image_value:
        if encoding_of(encoding_in).channels != 1:
            raise ConversionError('only pictures with one channel are scaled')
        return _shades(source, target.name, min_image_value, max_image_value, colormap)
    return convert(source, _PLAIN.get(encoding_in, encoding_in), target.name)


def _shades(source: Picture, target: str, least: float, most: float, colormap: int) -> Picture:
    values = np.nan_to_num((source.astype(np.float64) - least) * (255.0 / (most - least)))
    shades = np.clip(np.rint(values), 0, 255).astype(np.uint8)
    if colormap == -1:
        return convert(shades, 'mono8', target)
    coloured = np.asarray(require_opencv('color maps').applyColorMap(shades, colormap))
    coloured[np.isnan(source)] = 0
    return convert(coloured, 'bgr8', target)


def _labels(source: Picture) -> Picture:
    table = _label_colours()
    shown: Picture = table[source.reshape(source.shape[:2]) % len(table)]
    shown[source == 0] = 0
    return shown


@cache
def _label_colours() -> Picture:
    """Return the colour of each label as in ROS 2's cv_bridge, blue first.

    The colours are the named colours of CSS, in the alphabetical order of their names.
    """
    rgb = np.frombuffer(bytes.fromhex(_COLOURS), np.uint8).reshape(-1, 3)
    return np.ascontiguousarray(rgb[:, ::-1])


_COLOURS = (
    'eff8fff9ebd600ffff7effd3effffff5f5dcffe3c4000000ffebcd0000ff892be1a42a2adeb8865f9e9f7eff00d2691e'
    'ff7e506394ecfff8dcdc133b00ffff00008a008a8ab8850aa9a9a9006300a9a9a9bcb76b8a008a546b2eff8b009931cc'
    '8a0000e995798fbb8f473c8a2e4f4f2e4f4f00ced19300d2ff139200beff6969696969691e90ffb12121fff9ef218a21'
    'ff00ffdcdcdcf8f8ffffd600daa41f808080008000acff2e808080efffefff69b4cd5c5c4a0082ffffefefe68be6e6f9'
    'ffeff57bfb00fff9cdacd7e6ef8080dffffff9f9d2d2d2d290ed90d2d2d2ffb6c1ff9f791fb1aa86cef9778799778799'
    'afc4deffffdf00ff0031cd31f9efe6ff00ff80000066cdaa0000cdb954d2926fdb3bb3707a68ed00f99a47d1ccc61585'
    '18186ff5fff9ffe3e0ffe3b5ffdeac000080fcf5e68080006b8e22ffa400ff4500da6fd5ede8aa97fa97aeededffeed4'
    'ffdab8cd853effc0cadd9fddafdfe6800080ff0000bb8f8f4169e08a4512f98071f9a35f2d8a56fff5ed9f522cc0c0c0'
    '86ceeb6a5acd6f80906f8090fff9f900ff7e4682b4d2b48b008080d7bed7ff624640dfd0ed82edf5deb3fffffff5f5f5'
    'ffff009acd31'
)
