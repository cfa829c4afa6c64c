"""Check that a gain file is the one of a certificate: the law and all other members.

Contents are compared, not bytes: numbers by value, keys in any order. The expected contents follow
from model and law (``controller.content``), or are in the certificate's member ``controller``. An
older certificate without that member covers the law alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from takagi.certificates.checker.controller.content import FORMAT, file_content
from takagi.certificates.checker.files.differences import (
    MOST_COUNTED,
    Difference,
    differences_between,
    listed,
)
from takagi.certificates.checker.kernel.reader import member, number, read_json
from takagi.certificates.checker.kernel.refusal import CertificateError, OtherGains

# The versions of gain files before this form: law and names, but no program.
EARLIER = ("1", "2")
# The claim about the loop with the file's observer and filters, both of which it states.
OBSERVED, LOOP_MEMBERS = "running-loop", ("observer", "measurement")
# The limits of rates that it has; they are computed from the model's.
RATES = ("torque_rate", "pitch_rate", "pitch_time_constant")
# What the observer knows of the rotor.
ROTOR = ("torque_constant", "radius", "inertia", "gear_ratio", "torque_coefficient")


def compare_gains(data: dict[str, Any], gains: Path | str, *, allow_old: bool = False) -> str:
    """Return messages for the reader.

    Parameters
    ----------
    allow_old : accept files of earlier versions, of which not everything can be compared.

    Raises
    ------
    OtherGains : the contents of the file differ from the certificate, or some of them cannot be
        compared, as those of a file without limits or programs.
    CertificateError : it cannot be read, or has no law.
    """
    file = read_json(Path(gains))
    stated_law(file, str(gains))
    has_controller = "controller" in data
    controller = data.get("controller")
    # A file of an earlier version is the controller itself but for the law: nothing is computed.
    computed = isinstance(controller, dict) and "version" not in controller
    if not computed or not set(LOOP_MEMBERS) <= set(file):
        _require_observers(file, data, str(gains))
    expected = expected_file(data) if has_controller else {"law": data.get("gains")}
    if _samples_faster(file.get("sampling"), expected.get("sampling")):
        # Measured of the loop, not proved: gains that were changed by hand have those of before.
        file = {**file, "sampling": expected["sampling"]}
    differences = list(
        islice(_differences(file, expected, all_members=has_controller), MOST_COUNTED)
    )
    by_name = bool(differences) and has_controller and _calls_tables(file, data)
    if differences and not by_name:
        raise OtherGains(f"{gains}: {_told(differences)}")
    if isinstance(controller, dict) and controller.get("removable"):
        # Imported here: most laws have no premise that is 0/0 somewhere.
        from takagi.certificates.checker.files.replacements import require_premises

        kinds = [claim.get("kind") for claim in data["claims"]]
        require_premises(data["model"], data.get("gains"), controller, kinds)
    not_compared = left_out(file, expected, data)
    if not_compared and not allow_old:
        raise OtherGains(
            f"{gains}: {'; '.join(not_compared)}; write both files again with 'takagi certify "
            "MODEL --gains FILE --out CERT --gains-out NEW', or accept this with "
            "--allow-old-gain-files"
        )
    if by_name:
        not_compared.append("its program calls tables by their names, as earlier files do")
    return f"{gains}: {'; '.join(not_compared)}" if not_compared else ""


def left_out(file: Any, expected: dict[str, Any], data: dict[str, Any]) -> list[str]:
    """Return in words which members of the file, or of the expected file, are not compared."""
    if "controller" not in data:
        names = ", ".join(_printable(key) for key in sorted(set(file) - {"law"}))
        words = f"only its law is compared; the certificate does not cover {names}"
        return [words] if names else []
    reasons = []
    if "version" in data["controller"]:
        reasons.append(
            "of an earlier version; what it says beside its law is compared with the certificate's "
            "copy of it, not with model and law"
        )
    if missing := sorted(set(expected) - set(file)):
        reasons.append(f"it does not say {', '.join(missing)}: of these nothing is compared")
    return reasons


def _samples_faster(stated: Any, expected: Any) -> bool:
    """Return whether the file's longest sample time is at most that of the certificate."""
    if not (
        isinstance(stated, dict) and isinstance(expected, dict) and set(stated) == set(expected)
    ):
        return False
    try:
        theirs = number(stated, "longest", "sampling")
        return 0 < theirs and (
            expected["longest"] is None or theirs <= number(expected, "longest", "sampling")
        )
    except CertificateError:
        return False


def _require_observers(file: Any, data: dict[str, Any], gains: str) -> None:
    """Refuse a file whose observer or filters are missing, or are not those of a claim.

    The file may have rate limits, the rotor of the observer, and programs.  They must be those of
    the loop.

    Where the file follows from ``controller``, claim and file have been compared with it already.
    Then only a file that leaves a member out can be wrong.
    """
    for claim in member(data, "claims", "certificate"):
        if isinstance(claim, dict) and claim.get("kind") == OBSERVED:
            # Imported here: most certificates have no such claim.
            from takagi.certificates.checker.turbine.running_loop.inputs import (
                other_than_the_controller,
            )

            if differing := other_than_the_controller(claim, {"controller": file}, "claim"):
                message = differing.replace("the controller's", "the gain file's")
                raise _other_loop(gains, message)
            compared_members = {"limits": RATES, "rotor": ROTOR}
            for differing in _other_than_the_loop(file, _loop(data, claim), compared_members):
                raise _other_loop(gains, f"{differing} is not the certificate's")


def _loop(data: dict[str, Any], claim: Any) -> dict[str, Any]:
    """Return the computed part of the gain file of a claim, without the observer's gains.

    Raises
    ------
    CertificateError : it does not follow from model, law and the claim's filters.
    """
    from takagi.certificates.checker.controller.turbine_content import turbine_content

    controller = {"observer": {}, "measurement": claim["measurement"]}
    try:
        return turbine_content(data["model"], data["gains"], controller)
    except (AttributeError, LookupError, TypeError, ValueError, ArithmeticError) as error:
        raise _no_file(error) from error


def _other_than_the_loop(
    file: Any, loop: dict[str, Any], compared_members: Mapping[str, Sequence[str]]
) -> Iterator[str]:
    """Yield where the file differs from a loop in these members of its sections, or in a program.

    A file may have none of them.
    """
    for member_name, names in compared_members.items():
        stated = file.get(member_name)
        if stated is not None and not isinstance(stated, dict):
            yield member_name
            continue
        for name in names:
            if stated is not None and name in stated:
                path = member_name, name
                for difference in differences_between(stated[name], loop[member_name][name], path):
                    yield difference.place
    if "programs" in file:
        for difference in differences_between(file["programs"], loop["programs"], ("programs",)):
            yield difference.place


def _other_loop(gains: str, why: str) -> OtherGains:
    return OtherGains(
        f"{gains}: claims about the loop with its observer: {why}; give the gain file that they "
        "were made for"
    )


def stated_law(file: Any, source: str) -> Any:
    """Return the law of a gain file.

    Raises
    ------
    CertificateError : the file has none; says which other file it is, where that can be told.
    """
    if isinstance(file, dict) and "law" not in file and "claims" in file:
        raise CertificateError(
            f"{source}: this is a certificate, and a gain file is needed: give the gains.json of "
            "the same design"
        )
    if isinstance(file, dict) and "law" not in file:
        raise CertificateError(
            f"{source}: this is no gain file, for 'law' is missing: give the gains.json that "
            "'takagi design' wrote"
        )
    return member(file, "law", source)


def _calls_tables(file: Any, data: dict[str, Any]) -> bool:
    """Return whether the file differs only in how its program calls tables."""
    if not isinstance(data["model"], dict) or not data["model"].get("tables"):
        return False
    earlier = expected_file(data, called=True)
    return next(_differences(file, earlier, all_members=True), None) is None


def expected_file(data: dict[str, Any], *, called: bool = False) -> dict[str, Any]:
    """Return the contents of the gain file of a certificate with a ``controller``.

    ``called`` : with a program that calls tables by their names.

    Raises
    ------
    CertificateError : no gain file follows from model, law and ``controller``.
    """
    controller, law = data["controller"], data.get("gains")
    hashes = member(member(data, "provenance", "certificate"), "sha256", "provenance")
    try:
        if "version" in controller:
            # A file of an earlier version: its whole content is in the certificate.  Such files had
            # no program; one that stood here would be compared with nothing but itself.
            _require_earlier(controller)
            return {"format": FORMAT, **controller, "law": law}
        content = file_content(data["model"], law, controller, called=called)
        return {**content, "certificate": {"sha256": hashes, **content["certificate"]}}
    except (AttributeError, LookupError, TypeError, ValueError, ArithmeticError) as error:
        if isinstance(error, CertificateError):
            raise
        raise _no_file(error) from error


def _no_file(error: Exception) -> CertificateError:
    return CertificateError(
        f"certificate: no gain file follows from its model, gains and controller "
        f"({type(error).__name__}: {error}); make it again with 'takagi certify'"
    )


def _require_earlier(controller: dict[str, Any]) -> None:
    if str(controller["version"]) not in EARLIER or "programs" in controller:
        raise CertificateError(
            "certificate: controller.version is that of an earlier gain file, 1 or 2, which has no "
            "programs; make it again with 'takagi certify'"
        )


def _differences(file: Any, expected: Any, *, all_members: bool) -> Iterator[Difference]:
    for key in file:
        if key in expected or all_members:
            yield from differences_between(file[key], expected.get(key), (key,))


def _told(differences: list[Difference]) -> str:
    law = all(difference.path[0] == "law" for difference in differences)
    return (
        f"the {'law' if law else 'gain file'} is not the certificate's; {listed(differences)}; "
        "give the gain file of this certificate, or make a certificate of this file with 'takagi "
        "certify MODEL --gains FILE --out CERT'"
    )


def _printable(text: str) -> str:
    return ascii(text)[1:-1]
