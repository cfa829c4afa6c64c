"""Claims about closed loops, their exact proofs, and an independent checker.

    checker/        replays a certificate: standard library alone, shares no code with synthesis
    cross_check/    a second checker on another library, written separately
    audit/          the checker code that a verdict used, and a comparison of both checkers
    document/       the certificate file: model, law, claims as decimals, hashes
    requests/       what may be asked of a certificate, one request a file
    claims/         candidates of all other claims; ``certify``
    design/         from a turbine or plant to gains, law and checked certificate
    controller/     the members of a gain file other than the law
    sweep/          what is proved of a law at each point of a grid; tasks over several processes
    campaign/       random runs of a certified loop against its claims
    coq/            a certificate's matrices for a proof assistant

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.checker.kernel.refusal import CertificateError
    from takagi.certificates.checker.kernel.result import Checked, Claim, Verdict
    from takagi.certificates.checker.replay.certificate import check
    from takagi.certificates.claims.plant.certification import (
        Certificate,
        certify,
        load_certificate,
    )
    from takagi.certificates.design.given.runnable_law import law_from_gains
    from takagi.certificates.design.turbine.design import design_turbine
    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.certificates.design.turbine.settings import DesignSettings

__all__ = [
    "Certificate",
    "CertificateError",
    "Checked",
    "Claim",
    "DesignSettings",
    "TurbineDesign",
    "Verdict",
    "certify",
    "check",
    "design_turbine",
    "law_from_gains",
    "load_certificate",
]

_HOME = {
    "Certificate": "claims.plant.certification",
    "CertificateError": "checker.kernel.refusal",
    "Checked": "checker.kernel.result",
    "Claim": "checker.kernel.result",
    "DesignSettings": "design.turbine.settings",
    "TurbineDesign": "design.turbine.result",
    "Verdict": "checker.kernel.result",
    "certify": "claims.plant.certification",
    "check": "checker.replay.certificate",
    "design_turbine": "design.turbine.design",
    "law_from_gains": "design.given.runnable_law",
    "load_certificate": "claims.plant.certification",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.certificates.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
