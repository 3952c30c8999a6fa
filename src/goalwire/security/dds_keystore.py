"""Writes a keystore of ROS 2, for DDS Security: certificates, governance and permissions of the same policy.

    enclaves/NAME/key.pem, cert.pem          of the identity NAME; `robot.arm` is the enclave /robot/arm
    enclaves/NAME/identity_ca.cert.pem, permissions_ca.cert.pem
    enclaves/NAME/governance.p7s, permissions.p7s    signed (S/MIME); the same without signature as .xml

DDS plugins trust a certificate that has signed itself, so there is an authority for DDS alone, `dds.pem` in
goalwire's keystore. Source of the layout: sros2, rcl `security.c`.
"""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.serialization import pkcs7
from cryptography.x509.oid import NameOID

from goalwire.errors import SecurityError
from goalwire.security import certificates, storage
from goalwire.security.certificates import AUTHORITY_LIFE, IDENTITY_LIFE, Pair, pem_of
from goalwire.security.dds_permissions import governance_xml, permissions_xml
from goalwire.security.keystore import Keystore, read
from goalwire.security.policy_file import load_policy

_EARLIER = timedelta(days=1)
"""How long before their issue certificates become valid, as in sros2: Connext refuses brand-new ones as not
valid yet.
"""


def write_dds_keystore(keystore: Keystore, folder: Path, life: timedelta = IDENTITY_LIFE) -> list[str]:
    """Write the enclaves of all identities of a keystore, except for routers; return their paths.

    Enclaves that are in `folder` already are replaced. Raises SecurityError.
    """
    policy = load_policy(keystore.policy_path)
    authority = _authority(keystore)
    governance = governance_xml()
    enclaves = []
    try:
        for name in keystore.names():
            identity = keystore.identity(name)
            if certificates.kind_of(identity.certificate) == 'router' or not policy.knows(name):
                continue
            enclave = '/' + name.replace('.', '/')
            enclaves.append(enclave)
            certificate = _certify(authority, enclave, identity.key.public_key(), life)
            validity = certificate.not_valid_before_utc, certificate.not_valid_after_utc
            permissions = permissions_xml(f'CN={enclave}', policy.grants[name], validity)
            _write(
                folder / 'enclaves' / enclave[1:],
                authority,
                identity.key,
                certificate,
                {
                    'governance': governance,
                    'permissions': permissions,
                },
            )
    except OSError as error:
        raise SecurityError(f"'{folder}' cannot be written: {error.strerror or error}") from None
    return enclaves


def _write(
    place: Path,
    authority: Pair,
    key: ec.EllipticCurvePrivateKey,
    certificate: x509.Certificate,
    documents: dict[str, bytes],
) -> None:
    place.mkdir(storage.FOLDER, parents=True, exist_ok=True)
    private = key.private_bytes(
        serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
    )
    storage.replace(place / 'key.pem', private)
    storage.replace(place / 'cert.pem', pem_of(certificate), storage.PUBLIC)
    for name in ('identity_ca.cert.pem', 'permissions_ca.cert.pem'):
        storage.replace(place / name, pem_of(authority.certificate), storage.PUBLIC)
    for name, text in documents.items():
        storage.replace(place / f'{name}.xml', text, storage.PUBLIC)
        storage.replace(place / f'{name}.p7s', sign(authority, text), storage.PUBLIC)


def sign(authority: Pair, text: bytes) -> bytes:
    """Return a text with its signature, as S/MIME with the text in the clear (DDS Security 1.1, 9.4.1.1)."""
    builder = pkcs7.PKCS7SignatureBuilder().set_data(text)
    builder = builder.add_signer(authority.certificate, authority.key, hashes.SHA256())
    options = [pkcs7.PKCS7Options.Text, pkcs7.PKCS7Options.DetachedSignature]
    return builder.sign(serialization.Encoding.SMIME, options)


def _authority(keystore: Keystore) -> Pair:
    """Return the authority for DDS, which is made when it is first needed. Raises SecurityError."""
    keystore.site()  # raises unless this keystore can issue certificates
    path = keystore.path / 'dds.pem'
    if not path.exists():
        key = certificates.make_key()
        name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, 'goalwire DDS authority')])
        now = certificates.now()
        made = _build(name, key.public_key(), name, (now - _EARLIER, now + AUTHORITY_LIFE), is_authority=True)
        storage.create(path, Pair(key, (made.sign(key, hashes.SHA256()),)).pem())
    return certificates.read_pair(read(path), str(path))


def _certify(
    authority: Pair, enclave: str, public_key: ec.EllipticCurvePublicKey, life: timedelta
) -> x509.Certificate:
    subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, enclave)])
    now = certificates.now()
    validity = now - _EARLIER, min(now + life, authority.certificate.not_valid_after_utc)
    builder = _build(subject, public_key, authority.certificate.subject, validity, is_authority=False)
    return builder.sign(authority.key, hashes.SHA256())


def _build(
    subject: x509.Name,
    public_key: ec.EllipticCurvePublicKey,
    issuer: x509.Name,
    validity: tuple[datetime, datetime],
    *,
    is_authority: bool,
) -> x509.CertificateBuilder:
    """Return a certificate without its signature, with the extensions that sros2 writes, since DDS plugins
    know these.
    """
    constraints = x509.BasicConstraints(ca=is_authority, path_length=1 if is_authority else None)
    return (
        x509.CertificateBuilder()
        .subject_name(subject)
        .issuer_name(issuer)
        .public_key(public_key)
        .serial_number(x509.random_serial_number())
        .not_valid_before(validity[0])
        .not_valid_after(validity[1])
        .add_extension(constraints, critical=is_authority)
    )
