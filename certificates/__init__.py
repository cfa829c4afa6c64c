"""Claims about closed loops, their exact proofs, and an independent checker.

    checker/        replays a certificate: standard library alone, shares no code with synthesis
    cross_check/    a second decision of every obligation, with another library
    audit/          the checker code that a verdict used
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
    from takagi.certificates.checker.kernel.refusal import CertificateError as CertificateError
    from takagi.certificates.checker.kernel.result import Checked as Checked
    from takagi.certificates.checker.kernel.result import Claim as Claim
    from takagi.certificates.checker.kernel.result import Verdict as Verdict
    from takagi.certificates.checker.replay.certificate import check as check
    from takagi.certificates.claims.certification import Certificate as Certificate
    from takagi.certificates.claims.certification import certify as certify
    from takagi.certificates.claims.certification import load_certificate as load_certificate
    from takagi.certificates.design.given.turbine_law import law_from_gains as law_from_gains
    from takagi.certificates.design.plant.design import design_plant as design_plant
    from takagi.certificates.design.turbine.design import design_turbine as design_turbine
    from takagi.certificates.design.turbine.result import TurbineDesign as TurbineDesign
    from takagi.certificates.design.turbine.settings import DesignSettings as DesignSettings

_HOME = {
    "Certificate": "claims.certification",
    "CertificateError": "checker.kernel.refusal",
    "Checked": "checker.kernel.result",
    "Claim": "checker.kernel.result",
    "DesignSettings": "design.turbine.settings",
    "TurbineDesign": "design.turbine.result",
    "Verdict": "checker.kernel.result",
    "certify": "claims.certification",
    "check": "checker.replay.certificate",
    "design_plant": "design.plant.design",
    "design_turbine": "design.turbine.design",
    "law_from_gains": "design.given.turbine_law",
    "load_certificate": "claims.certification",
}
__all__ = sorted(_HOME)


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.certificates.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
