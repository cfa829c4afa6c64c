"""The pinned numbers of the turbine's checker: what they are, and what they were.

``numbers.json`` holds a text for each named quantity, in groups.  A text is the exact value where
that is short, and else its beginning and a hash of the exact value.

``python -m tests.certificates.pinned.turbine.numbers`` writes the numbers of today.  A text that
differs then is a change of what a certificate is worth: read it before it is committed.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from tests.certificates.pinned.turbine import (
    claim_numbers,
    coherent_numbers,
    content_answers,
    corner_numbers,
    edges_of_coherent,
    edges_of_counts,
    edges_of_files,
    edges_of_paper,
    gain_file_answers,
    linear_numbers,
    model_file_answers,
    pairs_and_limits,
    paper_claims,
    paper_numbers,
    rest_claims,
    rest_counts,
    rests_of_coherent,
    rests_of_one_integrator,
    rests_of_paper,
    rests_of_two_integrators,
    running_numbers,
    speed_numbers,
    table_answers,
    wind_rate_numbers,
)
from tests.certificates.pinned.turbine.values import Named, text

NUMBERS = Path(__file__).with_name("numbers.json")
PARTS = (
    claim_numbers,
    coherent_numbers,
    content_answers,
    corner_numbers,
    edges_of_coherent,
    edges_of_counts,
    edges_of_files,
    edges_of_paper,
    gain_file_answers,
    linear_numbers,
    model_file_answers,
    pairs_and_limits,
    paper_claims,
    paper_numbers,
    rest_claims,
    rest_counts,
    rests_of_coherent,
    rests_of_one_integrator,
    rests_of_paper,
    rests_of_two_integrators,
    running_numbers,
    speed_numbers,
    table_answers,
    wind_rate_numbers,
)
GROUPS: dict[str, Callable[[], Named]] = {
    name: numbers for part in PARTS for name, numbers in part.groups().items()
}


def found(group: str) -> dict[str, str]:
    """Return the numbers of a group as they are today."""
    return {name: text(value) for name, value in GROUPS[group]()}


def recorded() -> dict[str, dict[str, str]]:
    """Return the numbers of every group as they were."""
    read: dict[str, dict[str, str]] = json.loads(NUMBERS.read_text(encoding="utf-8"))
    return read


def main() -> None:
    """Write the numbers of today."""
    whole = {group: found(group) for group in GROUPS}
    NUMBERS.write_text(json.dumps(whole, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
