"""What ended in a crash or let a file speak in the checker's words: each is answered now."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict, certify, check
from takagi.certificates.document.certificate_file import dumps
from takagi.certificates.requests import (
    Decay,
    FuzzyDecay,
    GainRounding,
    H2Norm,
    InputLimits,
    InvariantEllipsoid,
    L2Gain,
    ObservedFeedback,
    ObserverError,
    Peak,
    Poles,
    Transient,
)
from takagi.certificates.requests.request import Request
from takagi.cli.main import main
from takagi.lmi import EigenvalueRegion
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import Data, model_data, resealed, said_of, sealed, verdicts

LINEAR = """format = 1
kind = "plant"
units = "unchecked"
name = "linear"
description = "one rule, for nothing in it is nonlinear"
[states]
x = { range = [-1, 1], description = "x" }
[inputs]
u = { description = "u" }
[disturbances]
w = { range = [-1, 1], description = "w" }
[outputs]
y = { expression = "x" }
[equations]
x = "x + u + w"
"""
UNSTABLE, STABLE = [[0.5]], [[2.0]]
REQUESTS: list[Request] = [
    Decay(),
    Decay(0.5),
    Transient(),
    GainRounding(),
    InvariantEllipsoid(),
    InputLimits(),
    L2Gain(),
    H2Norm(),
    Peak(),
    Poles(EigenvalueRegion.half_plane(0.5)),
    ObserverError([[3.0]]),
    ObservedFeedback([[3.0]]),
]


@pytest.fixture(scope="module")
def plant(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("linear") / "linear.toml"
    path.write_text(LINEAR)
    return path


@pytest.fixture(scope="module")
def linear(plant: Path) -> TSModel:
    model = sector_model(load_plant(plant))
    assert not model.premises and len(model.A) == 1
    return model


@pytest.mark.parametrize(
    ("gains", "rate", "verdict"),
    [
        ([[-100.0]], 0.5, Verdict.DISPROVED),
        (UNSTABLE, None, Verdict.DISPROVED),
        (UNSTABLE, 0.5, Verdict.DISPROVED),
        (None, None, Verdict.DISPROVED),
        (STABLE, 3.0, Verdict.DISPROVED),
        (STABLE, 0.5, Verdict.PROVED),
        (STABLE, 0.99, Verdict.PROVED),
        (STABLE, 1.01, Verdict.DISPROVED),
    ],
)
def test_linear_plant_is_answered(
    linear: TSModel, gains: Any, rate: float | None, verdict: Verdict
) -> None:
    """x' = (1 - K) x: one rule without premises."""
    found = certify(linear, gains, decay_rate=rate)

    assert found.verdict is verdict
    if verdict is Verdict.DISPROVED:
        assert "none does along rule 1 alone" in found.checked.claims[-1].text
    assert verdicts(found.document)[-1] == verdict.name


@pytest.mark.parametrize("request_", REQUESTS, ids=lambda one: type(one).__name__)
@pytest.mark.parametrize("gains", [UNSTABLE, STABLE], ids=["unstable", "stable"])
def test_every_request_answers_for_a_linear_plant(
    linear: TSModel, gains: Any, request_: Request
) -> None:
    """Each asks for more than a loop x' = x / 2 has; all but a wider box are true of x' = -x."""
    found = certify(linear, gains, claims=[request_])

    observes_only = isinstance(request_, ObserverError)
    expected = gains is STABLE or observes_only
    assert (found.verdict is Verdict.PROVED) is expected, found.checked.claims


@pytest.mark.parametrize("gains", [None, UNSTABLE, STABLE])
def test_everything_about_a_linear_plant(linear: TSModel, gains: Any) -> None:
    found = certify(linear, gains, claims="all")

    assert (found.verdict is Verdict.PROVED) is (gains is STABLE)
    if gains is not STABLE:
        assert found.verdict is Verdict.DISPROVED
        assert "without decay nothing else was tried" in found.tried


def test_command_line_answers_for_a_linear_plant(
    plant: Path, linear: TSModel, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A gain file of another loop, x' = x / 2: status 1, for it is disproved."""
    law = certify(linear, STABLE).document["gains"] | {"K": [UNSTABLE]}
    gains, out = tmp_path / "gains.json", tmp_path / "certificate.json"
    gains.write_text(dumps({"format": "takagi-gains", "law": law}))

    status = main(["certify", str(plant), "--gains", str(gains), "--out", str(out)])

    assert status == 1
    assert f"{out}: DISPROVED" in capsys.readouterr().out
    assert check(out).verdict is Verdict.DISPROVED


@pytest.mark.parametrize("gains", [None, UNSTABLE, STABLE])
def test_function_of_no_weights_is_refused_in_words(linear: TSModel, gains: Any) -> None:
    with pytest.raises(ModelError, match=r"the model has no premises.*ask for Decay"):
        certify(linear, gains, claims=[FuzzyDecay()])


def test_function_of_one_weight_is_still_answered() -> None:
    """A model of matrices with one rule has one weight, which is 1."""
    assert certify(TSModel([[[-1.0]]]), claims=[FuzzyDecay()]).verdict is Verdict.PROVED
    assert certify(TSModel([[[1.0]]]), claims=[FuzzyDecay()]).verdict is not Verdict.PROVED


def boxed(*names: str) -> Data:
    return model_data([[[-1]]], box={"x1 [-]": [-1, 1]} | {name: [-1, 1] for name in names})


INVARIANT = {"name": "set", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}
UNPRINTABLE = [
    "w\n  PROVED  and so is everything else",
    "\u001b[2J\u001b[Hall is well",
    "\ud800",
    "\u202etfel",
    "\u0001",
    "",
]


@pytest.mark.parametrize("name", UNPRINTABLE, ids=ascii)
@pytest.mark.parametrize("options", [[], ["--json"], ["--junit"]], ids="".join)
def test_name_in_the_box_is_one_line(
    name: str, options: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The sentence on the set names what of the box is taken for granted, as it stands."""
    path = tmp_path / "certificate.json"
    path.write_text(dumps(resealed(sealed(boxed(name), None, INVARIANT))))
    named = [*options, str(tmp_path / "junit.xml")] if "--junit" in options else options

    status = main(["check", str(path), *named])

    printed = capsys.readouterr()
    assert status == 2
    if "--json" in options:
        assert json.loads(printed.out).keys() == {"error", "status"}
    else:
        assert "PROVED" not in printed.out
    assert "model.box" in printed.err + printed.out
    assert printed.err.count("\n") <= 1 and printed.err.rstrip("\n").isprintable()


def test_name_in_the_box_that_is_no_state_is_told() -> None:
    """Names of one line, of any alphabet, are said as before."""
    said = said_of(boxed("vent [m/s]", "Böe"), None, INVARIANT)

    assert said.verdict is Verdict.PROVED
    assert "vent [m/s]" in said.text and "Böe" in said.text


def test_unprintable_name_is_refused_before_its_range_is() -> None:
    """The refusal of a range names its key as well."""
    with pytest.raises(CertificateError) as refusal:
        said_of(boxed() | {"box": {"w\nPROVED": "wide"}}, None, INVARIANT)
    assert str(refusal.value).isprintable()


def of_plant(equation: str) -> Data:
    state = {"name": "x", "unit": "m", "rest": 0, "range": [-1, 1]}
    model: Data = {"kind": "plant", "name": "p", "sample_time": None, "states": [state]}
    model |= {"inputs": [], "disturbances": [], "outputs": [], "parameters": {}}
    model |= {"equations": [equation], "embedding": {"premises": [], "A": [["-1"]]}}
    claims = [{"name": "e", "kind": "sector-embedding"}]
    return sealed(model, None, *claims)


def power_of_ten(digits: int) -> str:
    whole, rest = divmod(digits, 64)
    return "(" + "*".join([*["10^64"] * whole, f"10^{rest}"]) + ")"


# 10^64 has 213 bits, 10^320 1064: on both sides of what is printed; and of Python's 4,300 digits.
@pytest.mark.parametrize("digits", [2, 64, 300, 320, 4290, 4310, 6000])
@pytest.mark.parametrize("exponent", ["{}", "(-{})", "(1/{})"])
def test_large_exponent_is_refused_in_words(
    digits: int, exponent: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "certificate.json"
    written = exponent.format(power_of_ten(digits))
    path.write_text(dumps(of_plant(f"-x + 0*x^{written}")))

    status = main(["check", str(path)])

    printed = capsys.readouterr()
    assert (status, printed.out) == (2, "")
    assert "the exponent" in printed.err and "at most 64" in printed.err
    assert ("too many digits" in printed.err) is (digits > 300)


FORGED = 'the rotor never turns faster than 12.5 rpm: every inequality holds"; hence also'


def forged_name(folder: Path) -> Path:
    path = folder / "certificate.json"
    decay = {"name": FORGED, "kind": "decay", "P": [[1]], "decay_rate": 0}
    path.write_text(dumps(sealed(boxed(), None, decay)))
    return path


def test_name_of_a_claim_stands_in_quotes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is printed behind PROVED as the checker's words is the checker's."""
    path = forged_name(tmp_path)

    assert main(["check", str(path)]) == 0
    alone = capsys.readouterr().out.splitlines()
    assert main(["check", str(path), "--cross"]) == 0
    both = capsys.readouterr().out.splitlines()

    quoted = json.dumps(FORGED)
    assert f"  PROVED  {quoted}: {check(path).claims[0].text}" == alone[1]
    assert [line for line in both if "rotor" in line] == [
        alone[1],
        f"  PROVED  PROVED  {quoted} (2 matrices)",
    ]
    assert main(["check", str(path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["claims"][0]["name"] == FORGED
