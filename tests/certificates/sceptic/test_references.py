"""References of a law: what it integrates has to be what the model has, and nothing besides."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.kinds.claims import verdicts

Data = dict[str, Any]
NAMES = ["x", "y", "p_integral", "q_integral"]


def model() -> Data:
    """Return x' = u - x, y' = v + w + x/4; p is followed by x, and q by x + y."""
    ranges: dict[str, list[float]] = {
        "x": [-2, 2],
        "y": [-3, 3],
        "u": [-10, 10],
        "v": [-20, 20],
        "w": [-1, 1],
    }
    ranges |= {"p": [-0.5, 1], "q": [-1, 1]}

    def variables(names: list[str]) -> list[Data]:
        return [{"name": n, "unit": "-", "range": ranges.get(n), "rest": 0} for n in names]

    return {
        "kind": "plant",
        "name": "two",
        "source": "",
        "sample_time": None,
        "states": variables(NAMES),
        "inputs": variables(["u", "v"]),
        "disturbances": variables(["w", "p", "q"]),
        "parameters": {},
        "equations": ["u - x", "v + w + x/4", "x - p", "x + y - q"],
        "outputs": [],
        "references": [
            {"reference": "p", "integral": "p_integral", "follow": "x"},
            {"reference": "q", "integral": "q_integral", "follow": "x + y"},
        ],
        "embedding": {
            "form": "secant",
            "premises": [],
            "A": [["-1", "0", "0", "0"], ["1/4", "0", "0", "0"], ["1", "0", "0", "0"],
                  ["1", "1", "0", "0"]],
            "B": [["1", "0"], ["0", "1"], ["0", "0"], ["0", "0"]],
            "E": [["0", "0", "0"], ["1", "0", "0"], ["0", "-1", "0"], ["0", "0", "-1"]],
        },
    }  # fmt: skip


def law(references: Any) -> Data:
    return {
        "name": "pdc",
        "sample_time": None,
        "state_names": [f"{name} [-]" for name in NAMES],
        "input_names": ["u [-]", "v [-]"],
        "K": [[[3, 0, 2, 0], [0, 3, 0, 2]]],
        "trim": {"state": [0] * 4, "input": [0] * 2},
        "references": deepcopy(references),
    }


def verdict(whole: Data, gains: Data | None = None) -> str:
    """Return the verdict on the embedding; REFUSED where the file is refused."""
    document = certificate_document(
        model=whole,
        gains=gains or law(whole.get("references")),
        claims=[{"name": "embedding", "kind": f"{whole['embedding']['form']}-embedding"}],
        provenance={},
    )
    return verdicts(document)[0]


def changed(change: Callable[[Data], None]) -> Data:
    found = model()
    change(found)
    return found


def test_the_honest_one_is_proved() -> None:
    assert verdict(model()) == "PROVED"


@pytest.mark.parametrize("references", [None, [], {}, "p", 5, [5], [{}], [["p"]]])
def test_a_law_with_references_has_a_list_of_them(references: Any) -> None:
    """Model and law agree, and neither says what is integrated."""
    whole = model() | {"references": references}
    assert verdict(whole, law(references)) == "REFUSED"


def entry(k: int, **parts: Any) -> Callable[[Data], None]:
    def change(whole: Data) -> None:
        whole["references"][k] |= parts

    return change


def no_range(whole: Data) -> None:
    whole["disturbances"][1]["range"] = None


def unknown(whole: Data) -> None:
    """The law would not know its own reference."""
    whole["disturbances"][1]["unknown"] = True


def twice(whole: Data) -> None:
    whole["references"].append(dict(whole["references"][0]))


def one_signal(whole: Data) -> None:
    """Both integrals are of p; each is what its entry says."""
    whole["references"][1]["reference"] = "p"
    whole["equations"][3] = "x + y - p"
    whole["embedding"]["E"][3] = ["0", "-1", "0"]


def one_integral(whole: Data) -> None:
    whole["references"][1]["integral"] = "p_integral"


@pytest.mark.parametrize(
    "change",
    [
        entry(0, reference="r"),
        entry(0, reference="x"),
        entry(0, integral="r_integral"),
        entry(0, integral="p"),
        entry(0, follow=["x"]),
        entry(0, follow="x +"),
        entry(0, follow="z"),
        no_range,
        unknown,
        twice,
        one_signal,
        one_integral,
    ],
)
def test_entries_that_name_nothing_of_the_model_are_refused(change: Callable[[Data], None]) -> None:
    assert verdict(changed(change)) == "REFUSED"


def row(k: int, equation: str, follow: str = "", **matrices: list[str]) -> Callable[[Data], None]:
    """Return another equation with its rows of the matrices, and what its integral is of."""

    def change(whole: Data) -> None:
        whole["equations"][k] = equation
        if follow:
            whole["references"][k - 2]["follow"] = follow
        for name, entries in matrices.items():
            whole["embedding"][name][k] = entries

    return change


OTHER_INTEGRALS = {
    # The law would have to measure w.
    "of a disturbance": row(2, "x + w - p", "x + w", E=["1", "-1", "0"]),
    "of an input": row(2, "x + u - p", "x + u", B=["1", "0"]),
    # With a leak the integral rests where x is not p.
    "of itself": row(2, "x - p_integral - p", "x - p_integral", A=["1", "0", "-1", "0"]),
    "of another integral": row(2, "x + q_integral - p", "x + q_integral", A=["1", "0", "0", "1"]),
    "leaking": row(2, "x - p_integral - p", A=["1", "0", "-1", "0"]),
    "doubled": entry(0, follow="2*x"),
    # The reference moves the plant as well.
    "fed forward": row(0, "u - x + p/2", E=["0", "1/2", "0"]),
    "into the other one": row(3, "x + y + p/2 - q", E=["0", "1/2", "-1"]),
    # The plant itself depends on what the law integrates.
    "back into the plant": row(1, "v + w + x/4 + p_integral/10", A=["1/4", "0", "1/10", "0"]),
    # The integral of p is that of q.
    "of another reference": row(2, "x - q", E=["0", "0", "-1"]),
}


@pytest.mark.parametrize("change", OTHER_INTEGRALS.values(), ids=OTHER_INTEGRALS.keys())
def test_models_with_other_integrals_are_not_proved(change: Callable[[Data], None]) -> None:
    """Each embedding alone is right: without a law with references it is proved."""
    whole = changed(change)
    alone = {k: v for k, v in whole.items() if k != "references"}
    gains = {k: v for k, v in law([]).items() if k != "references"}

    assert verdict(alone, gains) == "PROVED"
    assert verdict(whole) != "PROVED"


def in_samples(whole: Data) -> None:
    """The row gives xi(t + T) = x - p; the law adds T (x - p) to what it has."""
    whole["sample_time"] = 0.1


def with_another_rate(whole: Data) -> None:
    """M = 1 but for one entry: xi' + x' = x - p, and xi' = 2 x - u - p."""
    whole["mass"] = [["1" if i == j else "0" for j in range(4)] for i in range(4)]
    whole["mass"][2][0] = "1"
    whole["embedding"]["form"] = "sector"
    whole["embedding"]["A"][2] = ["2", "0", "0", "0"]
    whole["embedding"]["B"][2] = ["-1", "0"]


@pytest.mark.parametrize("change", [in_samples, with_another_rate])
def test_rows_that_are_no_rates_are_no_integrals(change: Callable[[Data], None]) -> None:
    """Each row of an integral is h - r, and each embedding alone is right."""
    whole = changed(change)
    alone = {k: v for k, v in whole.items() if k != "references"}
    gains = law(model()["references"]) | {"sample_time": whole["sample_time"]}
    plain = {k: v for k, v in gains.items() if k != "references"}

    assert verdict(alone, plain) == "PROVED"
    assert verdict(whole, gains) == "UNDECIDED"


@pytest.mark.parametrize(
    "change",
    [
        lambda listed: listed.reverse(),
        lambda listed: listed.pop(),
        lambda listed: listed[0].update(follow="2*x"),
        lambda listed: listed[0].update(integral="q_integral"),
        lambda listed: listed.clear(),
    ],
)
def test_a_law_with_other_references_is_refused(change: Callable[[Any], None]) -> None:
    gains = law(model()["references"])
    change(gains["references"])
    assert verdict(model(), gains) == "REFUSED"
