"""The shipped definitions against what a real ROS 2 Jazzy says about the same types."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from goalwire.idl import registry, search_path, type_hash
from goalwire.idl.model import Field, MessageDefinition, Shape

DATA = Path(__file__).parents[1] / 'data'
SHARE = Path(search_path.SHIPPED)
DESCRIPTIONS = {
    item['type']: item['fields']
    for item in map(json.loads, (DATA / 'type_descriptions.jsonl').read_text(encoding='utf-8').splitlines())
    if not item['type'].startswith('humanoid_interfaces/')
}
CONSTANTS = json.loads((DATA / 'constants.json').read_text(encoding='utf-8'))
PACKAGES = sorted({name.partition('/')[0] for name in DESCRIPTIONS})
# A service's hash covers its request, its response and all that is in them. These are in the C code that
# rosidl generated for Jazzy; the vectors were taken where this package was not installed.
COMPOSITION = {
    'ListNodes': 'RIHS01_13f30d73a74c844ee4bacf78f3680f08777cad137f10fbd6a648544cc7b59d2a',
    'LoadNode': 'RIHS01_2e521ef6066fba6d7fc3a3b175d486709f01b4d738d9a59188858546fc8e5acd',
    'UnloadNode': 'RIHS01_dce562f83adc735ddcfe9dfb927b89293d4dd0fe2b8fc91e772fb83e970a43b0',
}
# Later than Jazzy, of which the vectors are. The hash is in the nav_msgs of Kilted.
KILTED = {
    'nav_msgs/msg/Goals': 'RIHS01_02305a51633b5c04d8979b878a7577cafd422f8a07465c878b17a920af3759e9',
}
# The packages of the programs in apps/programs and apps/bag; no vectors were taken of their types.
OF_PROGRAMS = ['action_tutorials_interfaces', 'rosbag2_interfaces', 'topic_tools_interfaces', 'turtlesim']
# Those that nodes for navigation, arms and cameras import. Another implementation judges their hashes.
OF_NODES = [
    'bond', 'geographic_msgs', 'map_msgs', 'moveit_msgs', 'nav2_msgs', 'object_recognition_msgs',
    'octomap_msgs', 'vision_msgs',
]  # fmt: skip
SHIPPED = sorted([*PACKAGES, 'composition_interfaces', *OF_PROGRAMS, *OF_NODES])

# type_description_interfaces/msg/FieldType
NUMBERS = {
    'int8': 2, 'uint8': 3, 'int16': 4, 'uint16': 5, 'int32': 6, 'uint32': 7, 'int64': 8, 'uint64': 9,
    'float32': 10, 'float64': 11, 'char': 3, 'bool': 15, 'byte': 16, 'string': 17, 'wstring': 18,
}  # fmt: skip
SHAPES = {Shape.SINGLE: 0, Shape.ARRAY: 48, Shape.BOUNDED: 96, Shape.UNBOUNDED: 144}


def described(field: Field) -> dict[str, object]:
    """A field of ours in the words of type_descriptions.jsonl."""
    of = field.type
    number = 1 if of.is_message else NUMBERS[of.base]
    if of.is_string and of.string_capacity:
        number += 4
    found: dict[str, object] = {'name': field.name, 'type_id': number + SHAPES[of.shape]}
    if of.is_message:
        found['nested_type_name'] = of.base
    if of.capacity:
        found['capacity'] = of.capacity
    if of.string_capacity:
        found['string_capacity'] = of.string_capacity
    if field.default is not None:
        found['default'] = str(field.default)
    return found


def without_filler(fields: list[dict[str, object]]) -> list[dict[str, object]]:
    """Drop the byte that rosidl adds to empty messages."""
    return [field for field in fields if field['name'] != 'structure_needs_at_least_one_member']


def messages_of(package: str) -> list[str]:
    """The messages of a package, those of its services and actions included."""
    names = [name for name in DESCRIPTIONS if name.startswith(f'{package}/')]
    return [name for name in names if isinstance(registry.definition(name), MessageDefinition)]


def test_exactly_these_packages_are_shipped() -> None:
    assert sorted(folder.name for folder in SHARE.iterdir()) == SHIPPED
    assert len(SHIPPED) == 35


def test_what_containers_of_nodes_are_asked_with_has_the_hashes_of_jazzy() -> None:
    found = search_path.find_package('composition_interfaces')
    assert found is not None
    assert sorted(found.files()) == [f'srv/{name}' for name in COMPOSITION]
    assert {name: type_hash(f'composition_interfaces/srv/{name}') for name in COMPOSITION} == COMPOSITION


def test_types_that_came_after_jazzy_have_the_hashes_of_kilted() -> None:
    assert {name: type_hash(name) for name in KILTED} == KILTED


def test_messages_for_nodes_have_the_hashes_that_rosbags_computes() -> None:
    store = get_typestore(Stores.ROS2_JAZZY)
    files = {
        f'{name}/msg/{file.stem}': file for name in OF_NODES for file in (SHARE / name).glob('msg/*.msg')
    }
    files |= {'shape_msgs/msg/SolidPrimitive': SHARE / 'shape_msgs' / 'msg' / 'SolidPrimitive.msg'}
    found: dict[str, Any] = {}
    for name, file in files.items():
        found |= get_types_from_msg(file.read_text(encoding='utf-8'), name)
    store.register({name: fields for name, fields in found.items() if name not in store.fielddefs})
    assert len(files) > 100
    assert {name: type_hash(name) for name in files} == {name: store.hash_rihs01(name) for name in files}


@pytest.mark.parametrize('package', OF_NODES)
def test_services_and_actions_for_nodes_use_shipped_types_alone(package: str) -> None:
    used = {
        name
        for file in (SHARE / package).glob('*/*.*')
        for name in re.findall(r'^(\w+)/\w+', file.read_text(encoding='utf-8'), re.MULTILINE)
    }
    assert used <= set(SHIPPED)
    found = search_path.find_package(package)
    assert found is not None
    for name in found.files():
        assert type_hash(f'{package}/{name}').startswith('RIHS01_')
    manifest = ET.parse(SHARE / package / 'package.xml').getroot()
    assert used - {package} <= {element.text for element in manifest.iter('depend')}


@pytest.mark.parametrize('package', PACKAGES)
def test_a_package_defines_exactly_the_types_of_the_vectors(package: str) -> None:
    found = search_path.find_package(package)
    assert found is not None
    derived = re.compile(r'/(srv|action)/\w+_')
    known = [*DESCRIPTIONS, *KILTED]
    wanted = {name for name in known if name.startswith(f'{package}/') and not derived.search(name)}
    assert {f'{package}/{name}' for name in found.files()} == wanted


@pytest.mark.parametrize('package', PACKAGES)
def test_fields_and_defaults_are_those_of_jazzy(package: str) -> None:
    wanted = {name: without_filler(DESCRIPTIONS[name]) for name in messages_of(package)}
    ours = {
        name: without_filler([described(field) for field in registry.message_definition(name).fields])
        for name in wanted
    }
    assert ours == wanted


@pytest.mark.parametrize('package', PACKAGES)
def test_constants_are_those_of_jazzy(package: str) -> None:
    ours = {
        name: {
            constant.name: list(constant.value) if isinstance(constant.value, bytes) else constant.value
            for constant in registry.message_definition(name).constants
        }
        for name in messages_of(package)
    }
    assert ours == {name: CONSTANTS.get(name, {}) for name in ours}


@pytest.mark.parametrize('package', SHIPPED)
def test_every_file_begins_by_saying_what_it_is_for(package: str) -> None:
    files = sorted((SHARE / package).glob('*/*.*'))
    first_lines = {file.name: file.read_text(encoding='utf-8').splitlines()[0] for file in files}
    assert first_lines
    assert {name for name, line in first_lines.items() if not re.fullmatch(r'# \S.{10,}', line)} == set()


@pytest.mark.parametrize(
    'name',
    [
        'geometry_msgs/msg/Point', 'sensor_msgs/msg/Imu', 'sensor_msgs/msg/LaserScan',
        'trajectory_msgs/msg/JointTrajectoryPoint', 'control_msgs/msg/JointTolerance',
        'control_msgs/action/GripperCommand_Result',
    ],
)  # fmt: skip
def test_physical_fields_say_their_unit(name: str) -> None:
    fields = [field for field in registry.message_definition(name).fields if not field.type.is_message]
    physical = [field for field in fields if field.type.base == 'float64' or field.name == 'ranges']
    assert physical
    assert [field.name for field in physical if not field.unit] == []


@pytest.mark.parametrize('package', SHIPPED)
def test_package_xml_names_the_package_and_what_it_uses(package: str) -> None:
    manifest = ET.parse(SHARE / package / 'package.xml').getroot()
    assert manifest.findtext('name') == package
    assert manifest.findtext('member_of_group') == 'rosidl_interface_packages'
    used = {
        field['nested_type_name'].partition('/')[0]
        for name, fields in DESCRIPTIONS.items()
        if name.startswith(f'{package}/')
        for field in fields
        if 'nested_type_name' in field
    }
    assert used - {package} <= {element.text for element in manifest.iter('depend')}
