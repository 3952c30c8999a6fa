"""The published package: the same bits from the same files, a README that stands alone, an SBOM, papers."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from email.message import Message
from email.parser import Parser
from importlib import util
from pathlib import Path
from types import ModuleType

import pytest
import yaml
from helpers.environments import ROOT
from helpers.isolation import NETWORK, isolated_env

from .conftest import build

PROJECT = tomllib.loads((ROOT / 'pyproject.toml').read_text(encoding='utf-8'))['project']


@pytest.fixture(scope='module')
def hooks() -> ModuleType:
    spec = util.spec_from_file_location('hatch_build', ROOT / 'hatch_build.py')
    assert spec is not None
    assert spec.loader is not None
    module = util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def metadata_of(wheel: Path) -> Message:
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if name.endswith('.dist-info/METADATA'))
        return Parser().parsestr(archive.read(name).decode())


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_two_builds_of_the_same_files_are_the_same(
    checkout: Path, wheel: Path, sdist: Path, tmp_path: Path
) -> None:
    """In another folder, with other times of the files."""
    elsewhere = tmp_path / 'elsewhere'
    shutil.copytree(checkout, elsewhere, copy_function=shutil.copyfile)
    (tmp_path / 'dist').mkdir()
    for kind, first in (('wheel', wheel), ('sdist', sdist)):
        assert digest(build(kind, elsewhere, tmp_path / 'dist')) == digest(first), kind


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_the_wheel_says_what_it_is(wheel: Path) -> None:
    metadata = metadata_of(wheel)
    assert metadata['License-Expression'] == 'Apache-2.0'
    assert metadata['Author'] == 'goalwire developers'
    assert 'actions' in metadata['Keywords']
    assert 'Project-URL' not in metadata  # none is public yet, and none is made up
    description = metadata.get_payload()
    assert isinstance(description, str)
    assert description.startswith('# goalwire')


@pytest.mark.slow
@pytest.mark.timeout(300)
def test_an_sbom_lists_what_the_wheel_requires(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        name = next(name for name in archive.namelist() if '.dist-info/sboms/' in name)
        bom = json.loads(archive.read(name))
    assert bom['bomFormat'] == 'CycloneDX'
    required = {re.split(r'[^\w.-]', each)[0].lower() for each in PROJECT['dependencies']}
    assert {component['name'] for component in bom['components']} == required
    assert set(bom['dependencies'][0]['dependsOn']) == required


def test_the_readme_of_the_index_has_no_link_that_leads_nowhere(hooks: ModuleType) -> None:
    text = hooks.readme_of_the_index((ROOT / 'README.md').read_text(encoding='utf-8'))
    prose = re.sub(r'^```.*?^```$', '', text, flags=re.MULTILINE | re.DOTALL)
    assert [link for link in re.findall(r'\]\(([^)\s]+)\)', prose) if '://' not in link] == []
    assert 'title=' not in text
    assert '```python\nimport rclpy' in text


@pytest.mark.parametrize(
    'file',
    [
        '.github/workflows/ci.yml',
        '.github/workflows/release.yml',
        'packaging/conda/recipe.yaml',
        'CITATION.cff',
    ],
)
def test_files_for_other_machines_can_be_read(file: str) -> None:
    assert isinstance(yaml.safe_load((ROOT / file).read_text(encoding='utf-8')), dict)


def test_the_papers_have_this_version() -> None:
    from goalwire import __version__

    assert yaml.safe_load((ROOT / 'CITATION.cff').read_text(encoding='utf-8'))['version'] == __version__
    recipe = yaml.safe_load((ROOT / 'packaging/conda/recipe.yaml').read_text(encoding='utf-8'))
    assert recipe['context']['version'] == __version__
    needed = {each.split()[0].removeprefix('python-') for each in recipe['requirements']['run']}
    required = {re.split(r'[^\w-]', each)[0].lower() for each in PROJECT['dependencies']}
    assert needed == required | {'python'}


def test_the_evidence_of_the_quality_declaration_is_there() -> None:
    text = (ROOT / 'QUALITY_DECLARATION.md').read_text(encoding='utf-8')
    named = [name for name in re.findall(r'`([^`]+)`', text) if not name.startswith('make ')]
    assert len(named) > 10
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_ci_runs_every_version_that_the_package_claims() -> None:
    jobs = yaml.safe_load((ROOT / '.github/workflows/ci.yml').read_text(encoding='utf-8'))['jobs']
    versions = {
        name.rpartition(' :: ')[2]
        for name in PROJECT['classifiers']
        if re.fullmatch(r'Programming Language :: Python :: 3\.\d+', name)
    }
    assert versions == set(jobs['tests']['strategy']['matrix']['python'])


HELLO = """
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_srvs.srv import Trigger

rclpy.init()
node = rclpy.create_node('hello')
node.create_service(Trigger, 'greet', lambda request, response: response)
client = node.create_client(Trigger, 'greet')
client.wait_for_service()
future = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, future)
print(future.result())
"""


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize('version', ['3.11', '3.12', '3.13', '3.14', '3.14t'])
def test_the_wheel_works_under_each_python_that_is_here(wheel: Path, tmp_path: Path, version: str) -> None:
    python = shutil.which(f'python{version}')
    if python is None or subprocess.run([python, '-V'], capture_output=True, check=False).returncode:
        pytest.skip(f'there is no Python {version}')
    subprocess.run([python, '-m', 'venv', tmp_path / 'venv'], check=True)
    own = tmp_path / 'venv' / ('Scripts' if sys.platform == 'win32' else 'bin') / 'python'
    done = subprocess.run(
        [own, '-m', 'pip', 'install', '-q', wheel], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    called = subprocess.run(
        [own, '-c', HELLO],
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
        cwd=tmp_path,
        env=isolated_env(NETWORK),
    )
    assert called.stdout == "std_srvs.srv.Trigger_Response(success=False, message='')\n"
    for command in ('version', 'course list'):
        subprocess.run(
            [own, '-m', 'goalwire', *command.split()], check=True, cwd=tmp_path, capture_output=True
        )
