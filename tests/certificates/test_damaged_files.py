"""Random damage with matching hashes: refused or undecided, never a traceback, never PROVED."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, Verdict, check, check_document
from takagi.certificates.checker.files.given_files import compare_model
from takagi.certificates.checker.turbine.effort_sharing.corners import BOUNDS, RANGES
from tests.certificates.kinds.claims import resealed

Document = dict[str, Any]

# Words, and what the proof does not lean on: the law's own wind filter, the model file's copy.
FREE = {"name", "units", "formula", "model_file", "state", "wind_filter", "provenance"}
# The loop's own claim does not speak of it; that of the actuators' rates does.
FREE |= {"torque_rate_limit"}
# What may stay true when it is made smaller, or larger; which of both is tested elsewhere.
WEAKER = {"wind_error", "wind_rate", "decay_rate", "integral_limit", "pitch_rate_limit"}
WEAKER |= {"frozen_wake", "effectiveness_limit", "rated_rotor_speed", "inertia", "multiplier"}
WEAKER |= {*RANGES, *BOUNDS, "pitch_max", "peaks", "wind_share"}
# The second function has room where only these winds are asked.
WEAKER |= {"settling"}
# Less than the unit by which stated ranges are wider than what is enclosed.
HAIR = 1e-9
STRANGE: list[Any] = [None, True, False, "", "1", "NaN", [], {}, [[]], [1], {"a": 1}, "\x00"]
STRANGE += [0, -1, 1, 1e-30, 1e30, -1e30, 10**30, 1e-12, [0, 0], [1, 0], [[1, 2], [3]]]


def paths(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the path of every part, leaves and branches alike."""
    if path:
        yield path
    if isinstance(value, (dict, list)):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from paths(value[key], (*path, key))


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def damage(document: Document, path: tuple[Any, ...], rng: random.Random) -> bool:
    place: Any = document
    for key in path[:-1]:
        place = place[key]
    way = rng.random()
    if way < 0.1:
        del place[path[-1]]
        return True
    if way < 0.15 and isinstance(place, list):
        place.append(place[path[-1]])
        return path[0] != "claims" or len(path) > 2
    before = place[path[-1]]
    if way < 0.4 and isinstance(before, (int, float)) and not isinstance(before, bool):
        place[path[-1]] = before * rng.choice([-1, 0, 0.5, 2, 1e6])
    else:
        place[path[-1]] = deepcopy(rng.choice(STRANGE))
    after = place[path[-1]]
    if _is_number(before) and _is_number(after) and abs(after - before) < HAIR:
        return False
    return isinstance(after, bool) or bool(after != before)


def survivors(short: Document, count: int, seed: int) -> list[str]:
    """Return where damage left the certificate PROVED though it should not have."""
    rng = random.Random(seed)
    # Most coefficients lie far from the trim, where nothing leans on them.
    where = [p for p in paths(short) if p[-1] == "coefficients" or "coefficients" not in p]
    found = []
    for path in (rng.choice(where) for _ in range(count)):
        damaged = deepcopy(short)
        if not damage(damaged, path, rng):
            continue
        try:
            verdict = check_document(resealed(damaged)).verdict
        except CertificateError:
            continue
        if verdict is Verdict.PROVED and not set(path) & FREE:
            found.append(str(path))
    return [path for path in found if not any(f"'{name}'" in path for name in WEAKER)]


@pytest.mark.slow
def test_much_random_damage(short: Document, reduced: bool) -> None:
    """The same campaign with other seeds, ten thousand times (reduced: 300)."""
    count = 300 if reduced else 10_000
    assert survivors(short, count, seed=3) == []


def test_the_gain_file_must_hold_the_same_numbers(short: Document, tmp_path: Path) -> None:
    """Checked with gains, the certificate is about these: one decimal apart is refused by name."""
    certificate, gains = tmp_path / "certificate.json", tmp_path / "gains.json"
    certificate.write_text(json.dumps(resealed(short)))
    gains.write_text(json.dumps({"law": short["gains"]}))
    assert "gain file" not in " ".join(check(certificate, gains=gains).messages)

    short["gains"]["overlap"] += 1e-9
    gains.write_text(json.dumps({"law": short["gains"]}))
    with pytest.raises(CertificateError, match="overlap"):
        check(certificate, gains=gains)


def test_matrices_are_those_of_no_file(tmp_path: Path) -> None:
    """Whatever hash a certificate of matrices holds: no claim says that the file has them."""
    known = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    data = {"model": {"kind": "takagi-sugeno", "files_sha256": {"plant.data": known}}}
    model = tmp_path / "plant.data"
    model.write_text("abc")

    with pytest.raises(CertificateError, match="no claim ties to a model file"):
        compare_model(data, model)
