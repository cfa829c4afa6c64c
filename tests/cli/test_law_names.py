"""The names of a turbine's laws: those that are typed, and those of files."""

from __future__ import annotations

import pytest

from takagi.certificates.design.turbine.settings import LAWS
from takagi.cli.main import main
from takagi.cli.options.turbine_options import IN_FILES, law_in_files, typed_name


def test_every_law_of_the_files_has_a_name_to_type() -> None:
    assert set(IN_FILES.values()) == set(LAWS)
    assert [typed_name(law_in_files(name)) for name in IN_FILES] == list(IN_FILES)


@pytest.mark.parametrize("filed", [*LAWS, "baseline"])
def test_names_of_files_may_be_typed_too(filed: str) -> None:
    assert law_in_files(filed) == filed
    assert law_in_files(None) is None


def test_several_laws_are_renamed_one_by_one() -> None:
    assert law_in_files(["published", "baseline", "coherent"]) == ["paper", "baseline", "coherent"]


@pytest.mark.parametrize("name", ["schulte", "published", "paper"])
def test_an_option_of_another_law_is_refused_by_either_name(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command itself translates the name: --overlap belongs to the effort-sharing law."""
    asked = ["design", "nrel5mw", "--law", name, "--overlap", "0.1", "--out", "never-written"]

    assert main(asked) == 2
    assert (
        "--overlap belongs to the effort-sharing law, but --law schulte" in capsys.readouterr().err
    )
