"""The gain file that belongs to a certificate, computed from its model and law.

Model and law determine programs, units, limits, equilibrium values, ranges, the rotor's inertia and
torque table: these are computed here. Observer gains, trim table and texts do not follow from them:
they are in the certificate's member ``controller``, with a hash like its other parts.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.controller.language import LANGUAGE
from takagi.certificates.checker.controller.texts import law_texts
from takagi.certificates.checker.kernel.reader import Number
from takagi.certificates.checker.kernel.refusal import CertificateError

FORMAT, VERSION = "takagi-gains", 3


def file_content(
    model: Any, law: Any, controller: Mapping[str, Any], *, called: bool = False
) -> dict[str, Any]:
    """Return the whole gain file of a law, except the hashes in its member ``certificate``.

    Parameters
    ----------
    model, law : as the certificate states them, read or not yet written.
    controller : the certificate's member of this name, with what model and law do not determine.
    called : tables called by their names, as files before this form have them.
    """
    head = {"format": FORMAT, "version": Number(str(VERSION)), "language": LANGUAGE, "law": law}
    # A model without a kind has no member that the other kind's file needs.
    kind = model.get("kind") if isinstance(model, Mapping) else None
    if kind is not None and (law["name"] == "pdc") != (kind != "turbine"):
        raise CertificateError(f"gains.name: {law['name']!a} is no law of this kind of model")
    # Imported here: a turbine's file does not need the code for plants, and vice versa.
    if law["name"] == "pdc":
        from takagi.certificates.checker.controller.plant_content import plant_content

        follows = plant_content(model, law, controller, called=called)
    else:
        from takagi.certificates.checker.controller.turbine_content import turbine_content

        follows = turbine_content(model, law, controller)
    return {**controller, **head, **law_texts(law, controller), **follows}
