"""The colours and pictures of a COLLADA file's materials.

Colours are values for a screen, as in a URDF. A file's opacity is not read: rviz gives all surfaces of a
robot the opacity of the URDF (RobotLink::updateAlpha), and many files say something else than they mean.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from goalwire.apps.console.state.collada.document import Document, elements_of, floats, inner
from goalwire.records import record
from goalwire.xml_tree import Element

Rgb: TypeAlias = tuple[float, float, float]

_SHADERS = ('phong', 'lambert', 'blinn', 'constant')
_WHITE: Rgb = (1.0, 1.0, 1.0)
_BLACK: Rgb = (0.0, 0.0, 0.0)


@record
class Material:
    """The look of a surface: its colour and the colour that it glows in, or a picture's address."""

    rgb: Rgb
    glow: Rgb = _BLACK
    picture: str = ''


class Materials:
    """The materials of a document. `picture_url` returns the address of a picture file, or ''."""

    def __init__(self, document: Document, picture_url: Callable[[str], str]) -> None:
        self._document = document
        self._picture_url = picture_url
        self._known: dict[str, Material | None] = {}

    def named(self, url: str) -> Material | None:
        """Return the material that '#id' names; None if it is not there or has no colour that can be shown.

        Raises ColladaError for colours that are not numbers.
        """
        if url not in self._known:
            material = self._document.find(url, 'material')
            effect = inner(material, 'instance_effect')
            found = (
                None if effect is None else self._document.find(effect.attributes.get('url', ''), 'effect')
            )
            self._known[url] = None if found is None else self._read(found)
        return self._known[url]

    def _read(self, effect: Element) -> Material | None:
        technique = inner(effect, 'profile_COMMON', 'technique')
        shader = (
            next((each for each in technique.children if each.tag in _SHADERS), None) if technique else None
        )
        if shader is None:
            return None
        diffuse = inner(shader, 'emission' if shader.tag == 'constant' else 'diffuse')
        texture = inner(diffuse, 'texture')
        if texture is not None:
            picture = self._picture(effect, texture.attributes.get('texture', ''))
            return Material(_WHITE, picture=picture) if picture else None
        colour = _colour(inner(diffuse, 'color'))
        if colour is None:
            return None
        glow = _BLACK if shader.tag == 'constant' else _colour(inner(shader, 'emission', 'color'))
        return Material(colour, glow or _BLACK)

    def _picture(self, effect: Element, name: str) -> str:
        """Return the address of the picture that a texture names: by a sampler of a surface, or directly."""
        parameters = {
            each.attributes.get('sid', ''): each for each in elements_of(effect) if each.tag == 'newparam'
        }
        for way in (('sampler2D', 'source'), ('surface', 'init_from')):
            found = inner(parameters.get(name), *way)
            name = name if found is None else found.text.strip()
        image = self._document.find(name, 'image')
        origin = inner(image, 'init_from')
        if origin is not None:
            origin = origin.find('ref') or origin  # COLLADA 1.5 has one more element
        return '' if origin is None else self._picture_url(origin.text.strip())


def _colour(element: Element | None) -> Rgb | None:
    """Return the first three numbers of <color>, between 0 and 1; None if there are not three or four."""
    if element is None:
        return None
    parts = [min(max(part, 0.0), 1.0) for part in floats(element).tolist()]
    if len(parts) not in {3, 4}:
        return None
    return (parts[0], parts[1], parts[2])
