"""One identity in one file, which `secure export` writes, to be carried to another machine.

The file is JSON: the identity with its key, the certificate that all trust, the policy and the list of
revoked names. Anyone with the file has the identity.
"""

from __future__ import annotations

import json
from datetime import datetime
from pathlib import Path

from goalwire.errors import SecurityError
from goalwire.security import certificates, revocation, storage
from goalwire.security.keystore import (
    Keystore,
    check_authority,
    check_name,
    make_carried,
    read,
    read_authority,
)
from goalwire.security.policy_file import read_policy
from goalwire.web_admission import new_token

_FORMAT = 'goalwire identity 1'
_FIELDS = ('format', 'name', 'identity', 'trust', 'policy', 'revoked')


def export(keystore: Keystore, name: str, path: Path, authority: str = '') -> None:
    """Write an identity's file; `authority` is the address at which its certificate is renewed.

    Raises SecurityError if the file exists, or the identity does not.
    """
    content = {
        'format': _FORMAT,
        'name': name,
        'identity': keystore.identity(name).pem().decode(),
        'trust': read(keystore.trust_path).decode(),
        'policy': keystore.policy_text(),
        'revoked': read(keystore.revoked_path).decode(),
    }
    if authority:
        content['authority'] = f'url = "{check_authority(authority, "--authority")}"\n'
    _create(path, json.dumps(content, indent=1).encode())


def export_for_browser(keystore: Keystore, name: str, path: Path) -> str:
    """Write an identity as PKCS #12, which browsers import, and return the password of the file.

    Raises SecurityError if the file exists, or the identity does not.
    """
    from cryptography.hazmat.primitives.serialization import BestAvailableEncryption, pkcs12

    pair, password = keystore.identity(name), new_token()
    data = pkcs12.serialize_key_and_certificates(
        name.encode(), pair.key, pair.certificate, pair.chain[1:], BestAvailableEncryption(password.encode())
    )
    _create(path, data)
    return password


def _create(path: Path, data: bytes) -> None:
    """Write a file that is not there yet. Raises SecurityError."""
    try:
        storage.create(path, data)
    except FileExistsError:
        raise SecurityError(f"'{path}' is there already; name another file") from None
    except OSError as error:
        raise SecurityError(f"'{path}' cannot be written: {error.strerror or error}") from None


def import_identity(folder: Path, path: Path) -> str:
    """Take an identity into a keystore, which is made if it is not there; return the identity's name.

    A keystore that exists must have the same authority. It gets the newer key, policy and list of revoked
    names; its earlier policy is kept beside the new one. Raises SecurityError, and changes nothing then.
    """
    content = _read(path)
    name = check_name(content['name'])
    pair = certificates.read_pair(content['identity'].encode(), str(path))
    trust = certificates.read_certificate(content['trust'].encode(), str(path))
    if not certificates.leads_to(pair.chain, trust) or certificates.common_name(pair.certificate) != name:
        raise SecurityError(f"'{path}' is damaged: its certificate is not one for '{name}' that it trusts")
    read_policy(content['policy'], f'{path}: policy.toml')
    if 'authority' in content:
        read_authority(content['authority'], f'{path}: authority.toml')
    revoked = revocation.read_revoked(content['revoked'])
    try:
        _put(folder, name, pair, content, revoked)
        if 'authority' in content:
            authority = content['authority'].encode()
            storage.replace(Keystore(folder).authority_path, authority, storage.PUBLIC)
    except OSError as error:
        raise SecurityError(f"'{folder}' cannot be written: {error.strerror or error}") from None
    return name


def _put(
    folder: Path,
    name: str,
    pair: certificates.Pair,
    content: dict[str, str],
    revoked: dict[str, datetime],
) -> None:
    if not (folder / 'trust.pem').exists():
        keystore = make_carried(
            folder, content['trust'].encode(), content['policy'].encode(), content['revoked'].encode()
        )
        storage.create(keystore.identity_path(name), pair.pem())
        return
    keystore = Keystore(folder)
    if read(keystore.trust_path).decode() != content['trust']:
        raise SecurityError(
            f"'{folder}' trusts another authority than the file does; import it into another folder"
        )
    if (folder / 'site.pem').exists():
        raise SecurityError(f"'{folder}' has the authority itself; import is for other machines")
    place = keystore.identity_path(name)
    if place.exists():
        before = keystore.identity(name).certificate.not_valid_before_utc
        if before > pair.certificate.not_valid_before_utc:
            raise SecurityError(f"'{folder}' has a newer certificate of '{name}' than the file")
    # A name that is revoked here stays revoked: an old file does not change that.
    both = {each: max(revoked.get(each, at), at) for each, at in keystore.list_revoked().items()}
    storage.replace(keystore.revoked_path, revocation.write_revoked(revoked | both).encode(), storage.PUBLIC)
    policy = keystore.policy_text()
    if policy != content['policy']:
        storage.replace(folder / 'policy.toml.before', policy.encode(), storage.PUBLIC)
        storage.replace(keystore.policy_path, content['policy'].encode(), storage.PUBLIC)
    storage.replace(place, pair.pem())


def _read(path: Path) -> dict[str, str]:
    try:
        content = json.loads(read(path))
    except ValueError:
        content = None
    if (
        not isinstance(content, dict)
        or content.get('format') != _FORMAT
        or not all(isinstance(content.get(field), str) for field in _FIELDS)
        or not isinstance(content.get('authority', ''), str)
    ):
        raise SecurityError(f"'{path}' is not a file that 'goalwire secure export' has written")
    return content
