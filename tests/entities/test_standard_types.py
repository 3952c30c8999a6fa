"""The types that every node offers are known by name and hash before their classes are made."""

import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from helpers.fresh import output_of

from goalwire import idl
from goalwire.entities import standard_types
from goalwire.entities.standard_hashes import MESSAGES, SERVICES
from goalwire.entities.standard_types import standard_message, standard_service


def class_of(type_name: str) -> type:
    package, kind, name = type_name.split('/')
    found: type = getattr(import_module(f'{package}.{kind}'), name)
    return found


@pytest.mark.parametrize('type_name', SERVICES)
def test_a_service_has_the_hash_and_class_of_its_definition(type_name: str) -> None:
    support = standard_service(type_name)
    assert support.type_hash == idl.type_hash(class_of(type_name))
    assert support.cls is class_of(type_name)


@pytest.mark.parametrize('type_name', SERVICES)
def test_the_parts_of_a_service_have_the_hashes_of_their_definitions(type_name: str) -> None:
    service = class_of(type_name)
    parts = service.Request, service.Response  # type: ignore[attr-defined]
    assert standard_service(type_name).part_hashes() == tuple(idl.type_hash(part) for part in parts)


@pytest.mark.parametrize('type_name', MESSAGES)
def test_a_message_has_the_hash_and_class_of_its_definition(type_name: str) -> None:
    support = standard_message(type_name)
    assert support.type_hash == idl.type_hash(class_of(type_name))
    assert support.has_buffers == idl.has_buffer_fields(class_of(type_name))
    assert support.cls is class_of(type_name)


def test_the_build_knows_every_type_that_a_node_asks_for(tmp_path: Path) -> None:
    program = """\
        import rclpy
        from goalwire.cdr import type_hash
        from rclpy.lifecycle import LifecycleNode
        from rclpy.parameter_event_handler import ParameterEventHandler
        type_hash.service_hashes = type_hash.message_facts = None  # they are not called
        rclpy.init()
        node = LifecycleNode('all', enable_logger_service=True)
        node.set_parameters([rclpy.Parameter('use_sim_time', value=True)])
        ParameterEventHandler(node)
        rclpy.shutdown()
    """
    assert output_of(program, cwd=tmp_path, RMW_IMPLEMENTATION='goalwire_memory') == ''


def test_a_checkout_that_was_never_installed_computes_the_hashes(tmp_path: Path) -> None:
    copy = tmp_path / 'goalwire'
    generated = shutil.ignore_patterns('standard_hashes.py', '__pycache__')
    shutil.copytree(Path(standard_types.__file__).parents[1], copy, ignore=generated)
    program = (
        'from goalwire.entities.standard_types import standard_message, standard_service\n'
        "service = standard_service('rcl_interfaces/srv/GetParameters')\n"
        "message = standard_message('rcl_interfaces/msg/ParameterEvent')\n"
        'print(service.type_hash, *service.part_hashes(), message.type_hash, message.has_buffers)\n'
    )
    done = output_of(program, cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert done.split() == [
        *SERVICES['rcl_interfaces/srv/GetParameters'],
        *map(str, MESSAGES['rcl_interfaces/msg/ParameterEvent']),
    ]


def test_nothing_is_imported_for_a_support_that_nobody_uses() -> None:
    program = (
        'import sys\n'
        'from goalwire.entities.standard_types import standard_service\n'
        "standard_service('rcl_interfaces/srv/GetParameters')\n"
        "print('rcl_interfaces' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=True)
    assert done.stdout == 'False\n'
