"""Campaigns on paper: words from made-up outcomes."""

from __future__ import annotations

from takagi.reports.campaign.tables import first_words


def test_words_name_what_broke_first_and_where() -> None:
    """Or that nothing did."""
    row = {"first": "speed error", "first_runs": 0.125, "first_winds": [3.0, 12.04]}

    assert first_words(row) == "speed error, 12.5 % (3.0 to 12.0 m/s)"
    assert first_words({"first": None}) == "nothing"
