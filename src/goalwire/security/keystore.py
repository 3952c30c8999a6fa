"""A keystore: a folder with a site's authorities, its identities, its policy and the revoked names.

    trust.pem          the certificate that all others lead to
    authority.pem      its key: vouches for the site's authority; may be kept elsewhere
    site.pem           key and certificate of the site's authority: vouches for identities
    identities/NAME.pem   key and certificates of one identity
    policy.toml        who may do what
    revoked.toml       whose certificates are refused
    authority.toml     where a carried identity has its certificate renewed; only if somebody renews it

Each identity is one file, since a file is replaced in one step: there is no moment at which key and
certificate do not belong together. A keystore on a robot has neither authority.pem nor site.pem.
"""

from __future__ import annotations

import os
import tomllib
from datetime import datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec

from goalwire.errors import SecurityError, did_you_mean, with_advice
from goalwire.files import read_regular
from goalwire.patterns import Pattern
from goalwire.security import certificates, revocation, storage
from goalwire.security.certificates import IDENTITY_LIFE, Pair
from goalwire.security.policy_text import FIRST_POLICY, add_identity

LARGEST = 1 << 20
"""The largest size of a file of a keystore, in bytes."""

_AUTHORITY = Pattern(r'https://([A-Za-z0-9.-]+|\[[0-9A-Fa-f:]+\]):\d{1,5}\Z')
_NAME = Pattern(r'[A-Za-z0-9][A-Za-z0-9_.-]{0,63}\Z')
_FIRST_ROLES = {'robot': ('robot',), 'person': ('viewer',), 'program': (), 'router': ()}


def check_name(name: str) -> str:
    """Return a name that a certificate and a file can have. Raises SecurityError for any other."""
    if not _NAME.match(name):
        raise SecurityError(
            f"'{name}' cannot be an identity's name: take up to 64 letters, digits, '_', '-' and '.', "
            f'the first of them a letter or a digit'
        )
    return name


def read(path: Path) -> bytes:
    """Return the content of a file of a keystore. Raises SecurityError."""
    try:
        return read_regular(os.fspath(path), LARGEST)
    except OSError as error:
        raise SecurityError(f"'{path}' cannot be read: {error.strerror or error}") from None


def read_authority(text: str, title: str) -> str:
    """Read an authority.toml and return its address. Raises SecurityError, which names `title`."""
    try:
        url = tomllib.loads(text).get('url')
    except tomllib.TOMLDecodeError as error:
        raise SecurityError(f"'{title}' cannot be read: {error}") from None
    return check_authority(url if isinstance(url, str) else '', title)


def check_authority(url: str, title: str) -> str:
    """Return the address of an authority. Raises SecurityError, which names `title`, if it cannot be one."""
    if not _AUTHORITY.match(url):
        raise SecurityError(f"{title}: '{url}' is not an address; write one like https://192.168.0.7:7449")
    return url


class Keystore:
    """An existing keystore on disk."""

    def __init__(self, path: Path) -> None:
        """Raises SecurityError if there is no keystore at `path`."""
        self.path = path
        self.trust_path = path / 'trust.pem'
        self.policy_path = path / 'policy.toml'
        self.revoked_path = path / 'revoked.toml'
        self.authority_path = path / 'authority.toml'
        if not self.trust_path.is_file():
            raise SecurityError(
                f"'{path}' is not a keystore: it has no trust.pem; make one: goalwire secure init {path}"
            )

    @classmethod
    def create(cls, path: Path) -> Keystore:
        """Make a keystore with new authorities. Raises SecurityError if there is something at `path`."""
        now = certificates.now()
        authority = certificates.make_authority(now)
        site = certificates.make_site(authority, now)
        trust = certificates.pem_of(authority.certificate)
        revoked = revocation.write_revoked({}).encode()
        try:
            with storage.new_folder(path) as folder:
                _fill(folder, trust, FIRST_POLICY.encode(), revoked)
                storage.create(folder / 'authority.pem', authority.pem())
                storage.create(folder / 'site.pem', site.pem())
        except FileExistsError:
            raise SecurityError(f"'{path}' is there already; name a new folder") from None
        except OSError as error:
            raise SecurityError(f"'{path}' cannot be made: {error.strerror or error}") from None
        return cls(path)

    # ---- what is in it

    def identity_path(self, name: str) -> Path:
        """Return the path of an identity's file, which need not exist."""
        return self.path / 'identities' / f'{check_name(name)}.pem'

    def names(self) -> list[str]:
        """Return the names of the identities whose keys are here."""
        return sorted(
            each.name.removesuffix('.pem')
            for each in (self.path / 'identities').glob('*.pem')
            if not each.name.startswith('.')
        )

    def identity(self, name: str) -> Pair:
        """Return an identity. Raises SecurityError if its key is not here, or cannot be used."""
        path = self.identity_path(name)
        if not path.exists():
            from difflib import get_close_matches

            near = did_you_mean(get_close_matches(name, self.names(), 3, 0.6))
            raise SecurityError(
                with_advice(f"there is no identity '{name}' in '{self.path}'", near or 'see: secure list')
            )
        return certificates.read_pair(read(path), os.fspath(path))

    def site(self) -> Pair:
        """Return the site's authority. Raises SecurityError if it is not here, as on a robot."""
        path = self.path / 'site.pem'
        if not path.exists():
            raise SecurityError(
                f"'{self.path}' has no authority that could sign; do this in the keystore that "
                f"'goalwire secure init' has made"
            )
        return certificates.read_pair(read(path), os.fspath(path))

    def trust(self) -> x509.Certificate:
        """Return the certificate that all other certificates lead to. Raises SecurityError."""
        return certificates.read_certificate(read(self.trust_path), os.fspath(self.trust_path))

    def list_revoked(self) -> dict[str, datetime]:
        """Return the revoked names, each with the time of issue up to which its certificates are refused.
        Raises SecurityError.
        """
        return revocation.read_revoked(read(self.revoked_path).decode(errors='replace'))

    def policy_text(self) -> str:
        """Return the text of policy.toml. Raises SecurityError."""
        return read(self.policy_path).decode(errors='replace')

    def authority_url(self) -> str:
        """Return where certificates are renewed; '' if nowhere. Raises SecurityError."""
        if not self.authority_path.exists():
            return ''
        return read_authority(read(self.authority_path).decode(errors='replace'), str(self.authority_path))

    # ---- what changes it

    def add(self, name: str, kind: str, roles: tuple[str, ...], life: timedelta = IDENTITY_LIFE) -> Pair:
        """Make a new identity, and name its roles in the policy. Raises SecurityError if it exists."""
        if self.identity_path(name).exists():
            raise SecurityError(f"'{name}' is there already; see: goalwire secure renew")
        self.site()
        policy = add_identity(self.policy_text(), name, roles or _FIRST_ROLES[kind])
        # The policy comes first: if power is lost in between, the policy only names an identity without a
        # key.
        storage.replace(self.policy_path, policy.encode(), storage.PUBLIC)
        return self.issue(name, kind, life)

    def issue(self, name: str, kind: str, life: timedelta = IDENTITY_LIFE) -> Pair:
        """Make a key and a certificate for a name without a key here. Raises SecurityError if the name has
        one.
        """
        made = self._make(name, kind, life)
        try:
            storage.create(self.identity_path(name), made.pem())
        except FileExistsError:
            raise SecurityError(f"'{name}' has a key already; see: goalwire secure renew") from None
        return made

    def renew(self, name: str, life: timedelta = IDENTITY_LIFE) -> Pair:
        """Put a new key and certificate in the place of an identity's old ones. Raises SecurityError."""
        made = self._make(name, certificates.kind_of(self.identity(name).certificate), life)
        self.put(name, made)
        return made

    def put(self, name: str, pair: Pair) -> None:
        """Write an identity, and replace the earlier identity of that name if there is one."""
        storage.replace(self.identity_path(name), pair.pem())

    def certify(
        self, name: str, kind: str, public_key: ec.EllipticCurvePublicKey, life: timedelta
    ) -> tuple[x509.Certificate, ...]:
        """Return a certificate for a name, whose key is elsewhere, followed by the certificates of its
        authorities.
        """
        return certificates.certify(self.site(), check_name(name), kind, public_key, self._life(name, life))

    def _make(self, name: str, kind: str, life: timedelta) -> Pair:
        return certificates.make_identity(self.site(), check_name(name), kind, self._life(name, life))

    def _life(self, name: str, life: timedelta) -> tuple[datetime, datetime]:
        """Return the beginning and end of validity of a certificate that is issued now."""
        now = certificates.now()
        begin = now - certificates.CLOCK_SKEW
        revoked = self.list_revoked().get(name)
        if revoked is not None:  # a new certificate must count as issued after the refused ones
            begin = max(begin, revoked + timedelta(seconds=1))
        return begin, now + life

    def revoke(self, name: str) -> datetime:
        """Refuse all certificates that a name has now; return the time. Its key is deleted.

        The name need not have a key here: its key may be only on a robot that was lost.
        """
        path = self.identity_path(name)
        until = certificates.now()
        revoked = self.list_revoked() | {name: until}
        storage.replace(self.revoked_path, revocation.write_revoked(revoked).encode(), storage.PUBLIC)
        path.unlink(missing_ok=True)
        return until


def _fill(folder: Path, trust: bytes, policy: bytes, revoked: bytes) -> None:
    """Write the files that every keystore has."""
    (folder / 'identities').mkdir(storage.FOLDER)
    storage.create(folder / 'trust.pem', trust, storage.PUBLIC)
    storage.create(folder / 'policy.toml', policy, storage.PUBLIC)
    storage.create(folder / 'revoked.toml', revoked, storage.PUBLIC)


def make_carried(path: Path, trust: bytes, policy: bytes, revoked: bytes) -> Keystore:
    """Make a keystore without authorities, for an identity from elsewhere. Raises OSError."""
    with storage.new_folder(path) as folder:
        _fill(folder, trust, policy, revoked)
    return Keystore(path)
