"""X.509 certificates on P-256: of authorities, and of the identities that they sign.

An authority signs the site's authority, and the site's authority signs identities. The certificate of an
identity has the identity's name as its common name, and its kind as its organizational unit. ROS 2's DDS
Security takes P-256 with SHA-256, too (sros2 `_utilities.py`).
"""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from typing import NamedTuple

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID
from cryptography.x509.verification import PolicyBuilder, Store, VerificationError

from goalwire.errors import SecurityError

AUTHORITY_LIFE = timedelta(days=3652)
SITE_LIFE = timedelta(days=366)
IDENTITY_LIFE = timedelta(days=30)
CLOCK_SKEW = timedelta(minutes=5)
"""How far another machine's clock may be behind: certificates are valid from this long before their issue."""


class Pair(NamedTuple):
    """A private key and its certificates: the key's own first, then its authorities'."""

    key: ec.EllipticCurvePrivateKey
    chain: tuple[x509.Certificate, ...]

    @property
    def certificate(self) -> x509.Certificate:
        """The certificate of the key."""
        return self.chain[0]

    def pem(self) -> bytes:
        """Return certificates and key as one text."""
        key = self.key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        )
        return b''.join(map(pem_of, self.chain)) + key


def pem_of(certificate: x509.Certificate) -> bytes:
    """Return a certificate as text."""
    return certificate.public_bytes(serialization.Encoding.PEM)


def _sign(
    subject: x509.Name,
    public_key: ec.EllipticCurvePublicKey,
    issuer: x509.Name,
    signer: ec.EllipticCurvePrivateKey,
    life: tuple[datetime, datetime],
    *,
    below: int | None,
    names: tuple[str, ...] = (),
) -> x509.Certificate:
    """Sign a certificate; `below` is how many levels of authorities it may sign below itself; None for an
    identity.
    """
    is_authority = below is not None
    builder = (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(public_key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(life[0])
        .not_valid_after(life[1])
        .add_extension(x509.BasicConstraints(ca=is_authority, path_length=below), critical=True)
        .add_extension(
            x509.KeyUsage(
                digital_signature=not is_authority,
                key_cert_sign=is_authority,
                crl_sign=is_authority,
                content_commitment=False,
                key_encipherment=False,
                data_encipherment=False,
                key_agreement=False,
                encipher_only=False,
                decipher_only=False,
            ),
            critical=True,
        )
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(public_key), critical=False)
        .add_extension(
            x509.AuthorityKeyIdentifier.from_issuer_public_key(signer.public_key()), critical=False
        )
    )
    if not is_authority:
        uses = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
        builder = builder.add_extension(x509.ExtendedKeyUsage(uses), critical=False)
        builder = builder.add_extension(
            x509.SubjectAlternativeName([x509.DNSName(name) for name in names]), critical=False
        )
    return builder.sign(signer, hashes.SHA256())


def _name(common: str, unit: str) -> x509.Name:
    return x509.Name(
        [
            x509.NameAttribute(NameOID.COMMON_NAME, common),
            x509.NameAttribute(NameOID.ORGANIZATIONAL_UNIT_NAME, unit),
        ]
    )


def make_authority(now: datetime) -> Pair:
    """Return a new authority with a self-signed certificate."""
    key = make_key()
    name = _name('goalwire authority', 'authority')
    life = (now - CLOCK_SKEW, now + AUTHORITY_LIFE)
    return Pair(key, (_sign(name, key.public_key(), name, key, life, below=1),))


def make_site(authority: Pair, now: datetime) -> Pair:
    """Return a new authority of a site, signed by `authority`."""
    key = make_key()
    end = min(now + SITE_LIFE, authority.certificate.not_valid_after_utc)
    subject, issuer = _name('goalwire site', 'site'), authority.certificate.subject
    life = (now - CLOCK_SKEW, end)
    certificate = _sign(subject, key.public_key(), issuer, authority.key, life, below=0)
    return Pair(key, (certificate,))


def make_key() -> ec.EllipticCurvePrivateKey:
    """Return a new key."""
    return ec.generate_private_key(ec.SECP256R1())


def certify(
    site: Pair, name: str, kind: str, public_key: ec.EllipticCurvePublicKey, life: tuple[datetime, datetime]
) -> tuple[x509.Certificate, ...]:
    """Return a certificate for a key, followed by the certificate of the site's authority."""
    end = min(life[1], site.certificate.not_valid_after_utc)
    certificate = _sign(
        _name(name, kind),
        public_key,
        site.certificate.subject,
        site.key,
        (life[0], end),
        below=None,
        names=(name.replace('_', '-'),),
    )
    return (certificate, *site.chain)


def make_identity(site: Pair, name: str, kind: str, life: tuple[datetime, datetime]) -> Pair:
    """Return a new key for an identity, with its certificate and the certificate of the site's authority."""
    key = make_key()
    return Pair(key, certify(site, name, kind, key.public_key(), life))


def read_pair(pem: bytes, title: str) -> Pair:
    """Read the text of `Pair.pem`. Raises SecurityError, which names `title`."""
    try:
        chain = tuple(x509.load_pem_x509_certificates(pem))
        key = serialization.load_pem_private_key(pem, None)
    except (ValueError, TypeError) as error:
        raise SecurityError(f"'{title}' holds no certificate with its key: {error}") from None
    if not isinstance(key, ec.EllipticCurvePrivateKey):
        raise SecurityError(f"'{title}' holds a key of another kind than P-256")
    if chain[0].public_key() != key.public_key():
        raise SecurityError(f"'{title}': its key is not that of its certificate")
    return Pair(key, chain)


def read_certificate(pem: bytes, title: str) -> x509.Certificate:
    """Read one certificate. Raises SecurityError, which names `title`."""
    try:
        return x509.load_pem_x509_certificate(pem)
    except ValueError as error:
        raise SecurityError(f"'{title}' holds no certificate: {error}") from None


def is_signed_by(certificate: x509.Certificate, issuer: x509.Certificate) -> bool:
    """Return True if an authority has signed a certificate."""
    try:
        certificate.verify_directly_issued_by(issuer)
    except (ValueError, TypeError, InvalidSignature):
        return False
    return True


def leads_to(chain: tuple[x509.Certificate, ...], trusted: x509.Certificate) -> bool:
    """Return True if each certificate is signed by the next, and the last by the trusted one."""
    issuers = (*chain[1:], trusted)
    return all(is_signed_by(each, issuer) for each, issuer in zip(chain, issuers, strict=True))


def verify(chain: tuple[x509.Certificate, ...], trusted: x509.Certificate) -> None:
    """Check an identity's certificate as TLS does, its authorities and its time included.

    Raises SecurityError.
    """
    verifier = PolicyBuilder().store(Store([trusted])).build_client_verifier()
    try:
        verifier.verify(chain[0], list(chain[1:]))
    except (VerificationError, IndexError) as error:
        raise SecurityError(f'the certificate is not accepted: {error}') from None


def life_of(certificate: x509.Certificate) -> timedelta:
    """Return for how long after its issue a certificate is valid."""
    return certificate.not_valid_after_utc - certificate.not_valid_before_utc - CLOCK_SKEW


def common_name(certificate: x509.Certificate) -> str:
    """Return the name that a certificate is for; empty if it has none."""
    return _attribute(certificate, NameOID.COMMON_NAME)


def kind_of(certificate: x509.Certificate) -> str:
    """Return the kind of identity that a certificate is for: its organizational unit."""
    return _attribute(certificate, NameOID.ORGANIZATIONAL_UNIT_NAME)


def _attribute(certificate: x509.Certificate, oid: x509.ObjectIdentifier) -> str:
    found = certificate.subject.get_attributes_for_oid(oid)
    return str(found[0].value) if len(found) == 1 else ''


def now() -> datetime:
    """Return the present time in whole seconds: certificates have no fractions."""
    return datetime.now(UTC).replace(microsecond=0)
