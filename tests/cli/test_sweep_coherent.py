"""`takagi sweep --law coherent`: what is asked wrongly is told; nothing is computed here."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.cli.verbs.sweep import run


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (["--law", "coherent"], "no axis was given: add --over"),
        (["--law", "coherent", "--over", "overlp=0.01"], "did you mean 'overlap'"),
        (["--law", "coherent", "--over", "inertia=0.1,0.95"], "at most 0.9"),
        (["--law", "coherent", "--over", "inertia=-0.1,0.1"], "at least 0"),
        (["--law", "paper-two-integrators", "--trade-off"], "belongs to --law effort-sharing"),
    ],
)
def test_misuse(
    asked: list[str], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Status 2, one line that says what to do, and no folder."""
    place = tmp_path / "map"

    assert run(["nrel5mw", *asked, "--out", str(place)]) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert not place.exists()
