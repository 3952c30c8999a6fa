"""The exercises: their names, the students' files, and the folders of their material."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from goalwire.records import record

MATERIAL = Path(__file__).parent / 'material'
INTERFACES = 'humanoid_interfaces'
"""The package with the interfaces of all exercises: a folder of MATERIAL, copied by `start`."""


@record
class Exercise:
    """One exercise. Its folder in MATERIAL and the module of its check have the name of its program."""

    number: int
    title: str
    name: str
    """The name of the exercise's program, without `.py`."""

    @property
    def program(self) -> str:
        """The file that a student works on."""
        return f'{self.name}.py'

    @property
    def folder(self) -> str:
        """The folder that `start` makes."""
        return f'exercise_{self.number}'

    def read(self, name: str) -> str:
        """Return a file of the exercise's material: 'task.md', 'hints.md', 'start.py' or 'solution.py'."""
        return (MATERIAL / self.name / f'{name}.template').read_text(encoding='utf-8')

    def hints(self) -> list[str]:
        """Return the exercise's hints, the gentlest first."""
        hints = re.split(r'^\d+\. ', self.read('hints.md'), flags=re.MULTILINE)[1:]
        return [' '.join(hint.split()) for hint in hints]


EXERCISES = (
    Exercise(1, 'A service that tells how the battery is', 'battery_service'),
    Exercise(2, 'An action that moves an arm, with feedback', 'arm_server'),
    Exercise(3, 'A client that uses a service and an action', 'mission_client'),
    Exercise(4, 'A call with time limits and retries', 'reliable_client'),
)


def start(exercise: Exercise, place: Path) -> list[Path]:
    """Make the exercise's folder below `place`; return the paths of its files.

    Raises FileExistsError if the folder exists, so that no work is overwritten.
    """
    folder = place / exercise.folder
    folder.mkdir(parents=True)
    shutil.copytree(MATERIAL / INTERFACES, folder / INTERFACES)
    (folder / 'README.md').write_text(exercise.read('task.md'), encoding='utf-8')
    (folder / exercise.program).write_text(exercise.read('start.py'), encoding='utf-8')
    return sorted(path for path in folder.rglob('*') if path.is_file())
