"""The humanoid as an ament_python package: `colcon build` and plain pip both install it.

The package includes its interface definitions, so that goalwire finds them from any folder, and the body's
description. Both come from the packages humanoid_interfaces and humanoid_description beside this package; an
sdist holds copies of them.
"""

from pathlib import Path

from setuptools import find_packages, setup
from setuptools.command.sdist import sdist

package_name = 'humanoid'
definitions = 'humanoid_definitions'  # a Python package with nothing but definition files
description = (
    'humanoid_description'  # the body's description; installed as a ROS package too, for package:// names
)
homes = {definitions: Path('../humanoid_interfaces'), description: Path('../humanoid_description')}
beside = {name: home for name, home in homes.items() if home.is_dir()}
body = beside.get(description, Path(description))


class SdistWithCopies(sdist):
    """Makes an sdist that holds copies of the packages beside this package."""

    def make_release_tree(self, base_dir: str, files: list[str]) -> None:
        super().make_release_tree(base_dir, [file for file in files if not file.startswith('..')])
        for file in files:
            if file.startswith('..'):
                name = next(name for name, home in homes.items() if Path(file).is_relative_to(home))
                copy = Path(base_dir, name, Path(file).relative_to(homes[name]))
                copy.parent.mkdir(parents=True, exist_ok=True)
                self.copy_file(file, str(copy))


setup(
    name=package_name,
    version='0.1.0',
    packages=[*find_packages(include=[package_name, f'{package_name}.*']), definitions, description],
    package_dir={name: str(home) for name, home in beside.items()},
    package_data={
        package_name: ['world/files/*.yaml'],
        definitions: ['package.xml', 'msg/*.msg', 'srv/*.srv', 'action/*.action'],
        description: ['package.xml', 'urdf/*.urdf', 'meshes/*.stl'],
    },
    cmdclass={'sdist': SdistWithCopies},
    data_files=[
        (
            'share/ament_index/resource_index/packages',
            [f'resource/{package_name}', f'resource/{description}'],
        ),
        (f'share/{description}', [str(body / 'package.xml')]),
        (f'share/{description}/urdf', [str(body / 'urdf' / 'humanoid.urdf')]),
        (f'share/{description}/meshes', sorted(str(file) for file in (body / 'meshes').glob('*.stl'))),
        (f'share/{package_name}', ['package.xml']),
        (f'share/{package_name}/launch', ['launch/humanoid.launch.py']),
    ],
    install_requires=['setuptools', 'rich>=13.7'],  # rich: progress bars of a mission
    extras_require={
        'sim': ['mujoco-core>=4.0', 'daqp>=0.8'],  # physics: 11 MB, and numpy
        'policy': ['onnxruntime>=1.17'],  # examples/onnx_walker.py: a learnt policy that walks the robot
        'world': ['numpy>=1.26', 'scipy>=1.11', 'PyYAML>=6.0.1'],  # worlds, and navigation in them: 35 MB
    },
    python_requires='>=3.11',
    zip_safe=False,  # goalwire reads the definitions as files
    maintainer='goalwire developers',
    maintainer_email='goalwire@example.org',
    description="A humanoid robot's services and actions, and a mission that uses them all.",
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'humanoid = humanoid.cli:main',
            'joint_state_service = humanoid.joints.service:main',
            'navigation_action_server = humanoid.navigation.server:main',
            'battery_service = humanoid.battery.service:main',
            'arm_action_server = humanoid.arm.server:main',
            'robot_state_publisher = humanoid.robot_state_publisher:main',
            'motor_board = humanoid.driver.board:main',
            'simulation = humanoid.physics.program:main',
            'world_server = humanoid.world.server:main',
            'localiser = humanoid.localisation.server:main',
            'navigator = humanoid.route.server:main',
            'mission = humanoid.mission.program:main',
        ],
        'goalwire.interfaces': [f'humanoid_interfaces = {definitions}'],
    },
)
