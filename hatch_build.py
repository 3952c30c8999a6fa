"""The build hooks: files that tools/generate.py makes, the SBOM, and the README of the package index.

An sdist has no generated files: it carries the generator, and the wheel built from it runs these hooks.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

SBOM = 'build/goalwire.cdx.json'


class GenerateHook(BuildHookInterface):  # type: ignore[type-arg]
    """Write the stubs and the table of hashes, which `artifacts` in pyproject.toml takes, and the SBOM."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002 - hatchling's
        subprocess.run([sys.executable, str(Path(self.root, 'tools', 'generate.py'))], check=True)
        if self.target_name == 'wheel':
            file = Path(self.root, SBOM)
            file.parent.mkdir(exist_ok=True)
            file.write_text(sbom(self.metadata.version, self.metadata.core.dependencies), encoding='utf-8')
            build_data['sbom_files'].append(SBOM)


class ReadmeHook(MetadataHookInterface):
    """Give the package index a README that stands on its own."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the readme, which pyproject.toml calls dynamic."""
        text = Path(self.root, 'README.md').read_text(encoding='utf-8')
        metadata['readme'] = {'content-type': 'text/markdown', 'text': readme_of_the_index(text)}


def readme_of_the_index(text: str) -> str:
    """Return the README without what only the repository has: pictures, and links to files beside it."""
    parts = re.split(r'(^```.*?^```$)', text, flags=re.MULTILINE | re.DOTALL)
    for index in range(0, len(parts), 2):
        without_pictures = re.sub(r'^!\[[^]]*\]\((?!https?:)[^)]*\)\n+', '', parts[index], flags=re.MULTILINE)
        parts[index] = re.sub(r'\[([^]]+)\]\((?!https?:)[^)\s]+\)', r'\1', without_pictures)
    fenced = ''.join(parts)
    return re.sub(r'^(```\w+) +title=\S+$', r'\1', fenced, flags=re.MULTILINE)


def sbom(version: str, requirements: list[str]) -> str:
    """Return the bill of materials as CycloneDX.

    The wheel holds nobody else's files, so this lists what it requires. No time and no number of its own is
    in it: two builds are the same, bit for bit.
    """
    main = {
        'type': 'library',
        'bom-ref': 'goalwire',
        'name': 'goalwire',
        'version': version,
        'purl': f'pkg:pypi/goalwire@{version}',
        'licenses': [{'license': {'id': 'Apache-2.0'}}],
    }
    names = {re.split(r'[^\w.-]', each)[0].lower(): each for each in sorted(requirements)}
    components = [
        {
            'type': 'library',
            'bom-ref': name,
            'name': name,
            'purl': f'pkg:pypi/{name}',
            'properties': [{'name': 'python:requirement', 'value': requirement}],
        }
        for name, requirement in names.items()
    ]
    bom = {
        'bomFormat': 'CycloneDX',
        'specVersion': '1.6',
        'version': 1,
        'metadata': {'component': main},
        'components': components,
        'dependencies': [{'ref': 'goalwire', 'dependsOn': list(names)}],
    }
    return json.dumps(bom, indent=2) + '\n'
