"""The humanoid as an ament_python package: `colcon build` and plain pip both install it."""

from setuptools import find_packages, setup

package_name = 'humanoid'

setup(
    name=package_name,
    version='0.1.0',
    packages=find_packages(include=[package_name, f'{package_name}.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{package_name}']),
        (f'share/{package_name}', ['package.xml']),
    ],
    install_requires=['setuptools', 'rich>=13.7'],  # without rich a mission shows plain lines
    python_requires='>=3.11',
    zip_safe=True,
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
            'mission = humanoid.mission.program:main',
        ],
    },
)
