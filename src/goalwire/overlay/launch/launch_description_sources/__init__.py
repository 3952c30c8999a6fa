"""launch.launch_description_sources: load launch files in Python, XML and YAML."""

from goalwire.errors import InvalidFrontendLaunchFileError
from goalwire.errors import InvalidLaunchFileError as InvalidPythonLaunchFileError
from goalwire.launching.aliases import add_modules
from goalwire.launching.sources import (
    AnyLaunchDescriptionSource,
    FrontendLaunchDescriptionSource,
    PythonLaunchDescriptionSource,
    XMLLaunchDescriptionSource,
    YAMLLaunchDescriptionSource,
    get_launch_description_from_any_launch_file,
    get_launch_description_from_frontend_launch_file,
    get_launch_description_from_python_launch_file,
    load_python_launch_file_as_module,
)

__all__ = [
    'AnyLaunchDescriptionSource',
    'FrontendLaunchDescriptionSource',
    'InvalidFrontendLaunchFileError',
    'InvalidPythonLaunchFileError',
    'PythonLaunchDescriptionSource',
    'XMLLaunchDescriptionSource',
    'YAMLLaunchDescriptionSource',
    'get_launch_description_from_any_launch_file',
    'get_launch_description_from_frontend_launch_file',
    'get_launch_description_from_python_launch_file',
    'load_python_launch_file_as_module',
]

add_modules(
    __name__,
    {
        'get_launch_description_from_any_launch_file': 'any_launch_file_utilities',
        'get_launch_description_from_frontend_launch_file': 'frontend_launch_file_utilities',
        'get_launch_description_from_python_launch_file': 'python_launch_file_utilities',
        'load_python_launch_file_as_module': 'python_launch_file_utilities',
        'InvalidPythonLaunchFileError': 'python_launch_file_utilities',
    },
)
