"""What may be claimed: the claims, their proof, and a checker that trusts nobody.

    checker/          replays a certificate: standard library alone, shares no code with synthesis
    document          the certificate file: model, law, claims as decimals, hashes
    coherent, paper   the claims about the loops with the coherent and the published laws
    certification     claims about Takagi-Sugeno models: ``certify``
    requests/         what may be asked of a certificate, one request a file
    equilibrium/      where a turbine's loop rests at constant winds: one rest, none, several
    turbine_design    from a turbine to a checked design
    gain_file_law     the law of a gain file, to run

Importing this package imports nothing heavy: names are looked up when they are used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.certificates.certification import Certificate, certify, load_certificate
    from takagi.certificates.checker.kernel.certificate import check
    from takagi.certificates.checker.kernel.refusal import CertificateError
    from takagi.certificates.checker.kernel.result import Checked, Claim, Verdict
    from takagi.certificates.equilibrium.search import closed_loop_equilibria
    from takagi.certificates.gain_file_law import law_from_gains
    from takagi.certificates.turbine_design import DesignSettings, TurbineDesign, design_turbine

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
    "closed_loop_equilibria",
    "design_turbine",
    "law_from_gains",
    "load_certificate",
]

_HOME = {
    "Certificate": "certification",
    "CertificateError": "checker.kernel.refusal",
    "Checked": "checker.kernel.result",
    "Claim": "checker.kernel.result",
    "DesignSettings": "turbine_design",
    "TurbineDesign": "turbine_design",
    "Verdict": "checker.kernel.result",
    "certify": "certification",
    "check": "checker.kernel.certificate",
    "closed_loop_equilibria": "equilibrium.search",
    "design_turbine": "turbine_design",
    "law_from_gains": "gain_file_law",
    "load_certificate": "certification",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.certificates.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
