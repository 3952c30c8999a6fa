"""The types that every node offers are known by name and hash before their classes are made."""

import subprocess
import sys
from importlib import import_module

import pytest

from goalwire import idl
from goalwire.entities.standard_types import (
    MESSAGE_HASHES,
    SERVICE_HASHES,
    standard_message,
    standard_service,
)


def class_of(type_name: str) -> type:
    package, kind, name = type_name.split('/')
    found: type = getattr(import_module(f'{package}.{kind}'), name)
    return found


@pytest.mark.parametrize('type_name', SERVICE_HASHES)
def test_a_service_has_the_hash_and_class_of_its_definition(type_name: str) -> None:
    support = standard_service(type_name)
    assert support.type_hash == idl.type_hash(class_of(type_name))
    assert support.cls is class_of(type_name)


@pytest.mark.parametrize('type_name', SERVICE_HASHES)
def test_the_parts_of_a_service_have_the_hashes_of_their_definitions(type_name: str) -> None:
    service = class_of(type_name)
    parts = service.Request, service.Response  # type: ignore[attr-defined]
    assert standard_service(type_name).part_hashes() == tuple(idl.type_hash(part) for part in parts)


@pytest.mark.parametrize('type_name', MESSAGE_HASHES)
def test_a_message_has_the_hash_and_class_of_its_definition(type_name: str) -> None:
    support = standard_message(type_name)
    assert support.type_hash == idl.type_hash(class_of(type_name))
    assert support.has_buffers == idl.has_buffer_fields(class_of(type_name))
    assert support.cls is class_of(type_name)


def test_nothing_is_imported_for_a_support_that_nobody_uses() -> None:
    program = (
        'import sys\n'
        'from goalwire.entities.standard_types import standard_service\n'
        "standard_service('rcl_interfaces/srv/GetParameters')\n"
        "print('rcl_interfaces' in sys.modules)\n"
    )
    done = subprocess.run([sys.executable, '-c', program], capture_output=True, text=True, check=True)
    assert done.stdout == 'False\n'
