"""From a file to verdicts: strict reading, comparison of hashes, replay of every claim."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.obligation import Decider, decided_exactly
from takagi.certificates.checker.kernel.reader import MOST_CLAIMS, integer, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Checked, Claim, Verdict
from takagi.certificates.checker.replay.claim_kinds import KINDS, PROBLEM_KINDS, READ, replay

# From the place of a claim in the file to what decides its obligations.
DeciderOf = Callable[[int], Decider]
FORMAT, VERSION = "takagi-certificate", 1
WITHOUT = "checked without a {} file: the verdict is about the {} inside the certificate"


def exact_decider(claim_index: int) -> Decider:
    """Return the decider of the first checker, the same for every claim."""
    return decided_exactly


def check(
    path: Path | str,
    *,
    gains: Path | str | None = None,
    model: Path | str | None = None,
    allow_old_gain_files: bool = False,
    decider_of: DeciderOf = exact_decider,
) -> Checked:
    """Return the verdict on every claim of a certificate file.

    Parameters
    ----------
    gains : a gain file; its law and all other contents must be those of the certificate.
    model : the model's data file; its contents must be those the certificate was made for.
    allow_old_gain_files : accept gain files of earlier versions, without limits or programs; a
        message says what is not compared.
    decider_of : returns what decides the obligations of a claim, from the claim's place in the
        file; rational arithmetic unless another reader is asked.

    Raises
    ------
    CertificateError : a file is unreadable, damaged, or of another version.
    OtherGains : the certificate is not about the given gain file.
    OtherModel : the certificate is not about the given model; the first difference is named.
    """
    data = reader.read_json(Path(path))
    _require_whole(data, str(path))
    messages = [WITHOUT.format("gain", "gains"), WITHOUT.format("model", "plant")]
    if gains is not None or model is not None:
        # Imported here, so that a check without files does not depend on the code that reads them.
        from takagi.certificates.checker.files.given_files import compare_files

        messages = compare_files(data, str(path), gains, model, messages, allow_old_gain_files)
    return _replayed(data, str(path), messages, decider_of)


def check_document(document: Mapping[str, Any], decider_of: DeciderOf = exact_decider) -> Checked:
    """Return the verdict on a certificate in memory, as if it were read from its file.

    Raises
    ------
    CertificateError : as for ``check``.
    """
    data = reader.read_text(json.dumps(document), "certificate")
    _require_whole(data, "certificate")
    return _replayed(data, "certificate", [], decider_of)


def _require_whole(data: dict[str, Any], path: str) -> None:
    """Refuse another format or version, and parts that are not those of the hashes."""
    if text(data, "format", "certificate") != FORMAT:
        raise CertificateError(f"{path}: the format is not {FORMAT!r}")
    if (version := integer(data, "version", "certificate")) != VERSION:
        words = f"{path}: a certificate of version {version}; this checker reads {VERSION}: "
        raise CertificateError(words + "use the takagi that wrote it, or make it again by certify")
    hashes = member(member(data, "provenance", "certificate"), "sha256", "provenance")
    # A hash detects accidental changes; a controller without a claim may have no hash.
    hashed = ["model", "gains", "claims"]
    if isinstance(hashes, dict) and "controller" in hashes:
        hashed.append("controller")
    for name in hashed:
        if text(hashes, name, "provenance.sha256") != reader.digest(data.get(name)):
            why = f"the {name} changed after the certificate was made (the hash differs)"
            raise CertificateError(f"{path}: {why}; make it again with 'takagi certify'")


def _replayed(
    data: dict[str, Any], path: str, messages: list[str], decider_of: DeciderOf
) -> Checked:
    claims = reader.listed(data, "claims", path, 1, MOST_CLAIMS)
    kinds = [text(claim, "kind", f"claims[{i}]") for i, claim in enumerate(claims)]
    if not READ.issuperset(kinds):
        # Imported here: a file with kinds that are all read does not depend on it.
        from takagi.certificates.checker.replay.containment import refuse_removed_kinds

        refuse_removed_kinds(kinds)
    model, gains = member(data, "model", "certificate"), data.get("gains")
    if not set(PROBLEM_KINDS).isdisjoint(kinds):
        # Imported here: most certificates are about a loop.
        from takagi.certificates.checker.problem.problem_claim import require_alone

        messages = require_alone(gains, path, messages)
    loop = None
    if any(kind in KINDS for kind in kinds):
        # Imported here: a turbine's loop does not need it, because it is not a sum over rules.
        from takagi.certificates.checker.replay.loop_reading import read_model_loop

        loop = read_model_loop(model, gains)
    if isinstance(gains, dict) and {"observer", "blending", "references", "integrators"} & {*gains}:
        # Imported here: most laws are gains alone.
        from takagi.certificates.checker.replay.containment import require_whole_law

        require_whole_law(model, gains, kinds)
    outcomes: list[Outcome] = []
    for i, claim in enumerate(claims):
        text(claim, "name", f"claims[{i}]")
        outcomes.append(replay(claim, data, loop, outcomes, f"claims[{i}]", decider_of(i)))
    if isinstance(model, dict) and model.get("kind") == "plant":
        # Imported here: for a turbine or for matrices no model has to contain a plant.
        from takagi.certificates.checker.replay.containment import of_its_slopes, of_the_plant

        outcomes = of_its_slopes(of_the_plant(outcomes, kinds, path), kinds, loop, path)
    return concluded([outcome.in_words() for outcome in outcomes], messages)


def concluded(claims: list[Claim], notes: list[str]) -> Checked:
    """Return the verdict on the whole; ``notes`` are the messages."""
    verdicts = {claim.verdict for claim in claims}
    overall = Verdict.UNDECIDED
    if Verdict.DISPROVED in verdicts:
        overall = Verdict.DISPROVED
    elif verdicts == {Verdict.PROVED}:
        overall = Verdict.PROVED
    return Checked(overall, claims, notes)
