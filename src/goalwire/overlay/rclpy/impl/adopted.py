"""What the entities of an AsyncNode have in common."""

from __future__ import annotations

from collections.abc import Callable


class Adopted:
    """To be mixed in first: the node learns of an entity's destruction, and cancels its callbacks."""

    on_destroy: Callable[[], object] | None = None

    def destroy(self) -> None:
        """End it, and cancel the callbacks that run, save one that calls this. Idempotent."""
        super().destroy()  # type: ignore[misc]  # the entity's
        if self.on_destroy is not None:
            self.on_destroy()
