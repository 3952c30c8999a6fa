"""The things that a user does with the page in a browser, and waits for there."""

from __future__ import annotations

from functools import partial
from itertools import count
from typing import Any

from helpers.patience import BROWSER_MS, wait_for

_FEW_PICTURES = """
    let scene
    Object.defineProperty(window, 'goalwireScene', {
        configurable: true,
        get: () => scene,
        set: made => {
            scene = made
            if (made) made.frames = 1
        },
    })
"""
"""Draws the robot's scene once a second at most. Without a graphics card the processor draws each
pixel, and would do nothing else."""


_SHOWN = """slider => {
    const [now, min, max] = ['now', 'min', 'max'].map(each => +slider.getAttribute(`aria-value${each}`))
    return (now - min) / (max - min) }"""
"""Where a slider's thumb is, as a part of its length."""


def new_context(browser: Any, width: int, height: int, **options: Any) -> Any:
    """Make a context of pages of so many pixels, with the patience of a browser and without animations."""
    size = {'width': width, 'height': height}
    context = browser.new_context(viewport=size, reduced_motion='reduce', **options)
    context.set_default_timeout(BROWSER_MS)
    context.add_init_script(_FEW_PICTURES)
    return context


def until(page: Any, expression: str, argument: object = None) -> Any:
    """Wait until an expression of the page's is true, and return it."""
    return page.wait_for_function(expression, arg=argument, timeout=BROWSER_MS, polling=50).json_value()


def copied(page: Any, button: str, *parts: str) -> str:
    """Press a button that copies, wait until the clipboard's text has these parts, and return it."""
    page.click(f'text={button}')
    read = partial(page.evaluate, '() => navigator.clipboard.readText()')
    wait_for(lambda: all(part in read() for part in parts), f'a copied text that has {parts}')
    return str(read())


def view(page: Any, name: str) -> None:
    """Choose a view of the page."""
    page.click(f'[data-view={name}]')
    page.wait_for_selector(f'[data-view={name}].chosen')


def row(page: Any, key: str) -> None:
    """Choose a row of a table, and wait until the page shows what it names."""
    page.click(f'tr[data-key="{key}"]')
    page.wait_for_selector(f'.gw-title:text-is("{key}")')


def choose(page: Any, select: str, option: str) -> None:
    """Choose an option of a list that opens."""
    page.locator('.q-select', has=page.locator(select)).click()
    page.click(f'.q-menu .q-item:has-text("{option}")')
    page.wait_for_selector('.q-menu', state='detached')  # while it fades it takes what the mouse does


def drag(page: Any, joint: str, to: float) -> None:
    """Drag a joint's slider to a part of its length."""
    slider = page.locator(f'[data-joint={joint}]:not(.disabled)')  # free once the server knows the choice
    slider.scroll_into_view_if_needed()
    at = count()

    def grab() -> bool:
        """Press on the slider; False if the page has moved it at that moment, and the mouse has missed it."""
        box = slider.bounding_box()
        page.mouse.move(box['x'] + box['width'] * 0.4, box['y'] + box['height'] / 2)
        page.mouse.down()
        page.mouse.move(box['x'] + box['width'] * to, box['y'] + box['height'] / 2, steps=4)
        if slider.evaluate("slider => slider.classList.contains('q-slider--active')"):
            return True
        page.mouse.up()
        return False

    def follows() -> bool:
        """Move on by a pixel, or back: the slider follows its joint until the server knows who holds it."""
        box = slider.bounding_box()
        page.mouse.move(box['x'] + box['width'] * to + next(at) % 2, box['y'] + box['height'] / 2)
        shown: float = slider.evaluate(_SHOWN)
        return abs(shown - to) < 0.02

    wait_for(grab, f'the mouse on the slider of {joint}')
    wait_for(follows, f'the slider of {joint} at {to}')
    page.mouse.up()


def confirm(page: Any) -> None:
    """Say yes to the question whether to send."""
    page.click('.q-dialog [data-send]')
    page.wait_for_selector('.q-dialog', state='detached')
