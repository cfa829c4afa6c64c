"""Textbook plants that are not built in: each is proved as it stands, and settles when it is run.

The simulation (``textbook_loop``) reads the plant file and the certificate without takagi.  The
table of docs/gallery-table.md is written by benchmarks/gallery.py.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from takagi.certificates import Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.design.design import NoDesign
from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import check_limits
from takagi.models import Plant, TSModel, load_model, partial_load_model, sector_model
from takagi.models.files.library import built_in_kinds
from takagi.models.plant_files.loader import PlantFile
from takagi.models.turbine.loader import load_turbine
from takagi.models.turbine.region_models import lowest_wind
from tests.certificates.kinds.claims import resealed
from tests.gallery.textbook_loop import textbook_loop
from tests.gallery.turbine_claims import turbine_claims

HERE = Path(__file__).resolve().parent
FILES = {file.stem: file for file in sorted((HERE / "plants").glob("*.toml"))}
PAGE = (HERE.parents[1] / "docs/gallery-table.md").read_text(encoding="utf-8")
TURBINES = sorted((HERE / "turbines").glob("*.toml"))
QUICK = ("chua", "jet_engine")
PROVED = sorted(FILES)
# Determinants of mass matrices, and sums of several exponentials, take sympy seconds; the rows of
# the fermenter are longer than it simplifies, so that the checker alone shows the identity.  The
# premises of the helicopter are bounded in six seconds.
SLOW_MODELS = {"furuta_pendulum", "klatt_engell", "fermenter", "helicopter"}
# Half a second to one and a half: the slow tests prove these too.
SECONDS = {"bioreactor", "quadruple_tank", "stirred_tank", "vehicle_steering"}
REDUCED = {*sorted(set(PROVED) - SLOW_MODELS)[::2], "fermenter", "helicopter"}


@cache
def plant(name: str) -> Plant:
    found = load_model(FILES[name])
    assert isinstance(found, Plant)
    return found


@cache
def name_of(file: str | Path) -> str:
    """The name that a plant's file states, without the plant, whose rest may have to be solved."""
    return PlantFile.of(file).entry.name or Path(file).stem


@cache
def model_of(name: str) -> TSModel:
    return sector_model(plant(name))


def test_twelve_or_more_plants_are_not_built_in() -> None:
    """The twelve that were asked for have other names, and other files, than the library's."""
    names = {name_of(name) for name, kind in built_in_kinds().items() if kind == "plant"}

    assert len(PROVED) >= 12 and len(names) >= 12
    assert not {name_of(file) for file in FILES.values()} & names
    assert not FILES.keys() & built_in_kinds().keys()


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.slow] * (name in SECONDS))
        for name in sorted(set(PROVED) - SLOW_MODELS)
    ],
)
def test_the_sector_model_is_the_plant(name: str) -> None:
    """Every file is read, has a source, and its model is the plant by algebra."""
    model = model_of(name)

    assert plant(name).source
    assert model.derivation is not None
    assert model.derivation.exactness == "checked symbolically"


@pytest.mark.parametrize("name", sorted(FILES))
def test_the_page_has_a_row_for_every_plant(name: str) -> None:
    assert f"| [{name_of(FILES[name])}](../tests/gallery/plants/{name}.toml) |" in PAGE


def test_an_input_that_enters_by_its_cube_has_one_gain_for_all_rules() -> None:
    """The F-8's tail deflection enters as 0.63 u^3: u^2 stands in premises, bounded by its range.

    The law knows u only afterwards, so that its gain depends on no premise.
    """
    model = model_of("aircraft")
    assert model.derivation is not None and model.derivation.form is not None
    premises = model.derivation.form.factored.premises
    assert any(sp.Symbol("u", real=True) in e.free_symbols for e in premises.values())
    made = design_plant(plant("aircraft"))

    assert not isinstance(made, NoDesign)
    assert made.proved
    assert len(made.document["gains"]["K"]) == 1
    assert any("depends on an input" in note for note in made.notes)


def test_the_mass_matrix_of_an_arm_takes_two_premises() -> None:
    """Slotine and Li's arm: 1/det M and the one moving sum in adj M; all corners are inverses.

    Each entry of the inverse bounded by itself gave 64 rules, some with an input matrix of the
    opposite determinant, for which no gains exist.
    """
    model = model_of("two_link_arm")

    assert len(model.A) == 16
    assert all(np.linalg.det(B[2:]) > 0 for B in model.B)


@pytest.mark.parametrize("name", ["chemostat", "predator_prey"])
def test_a_fraction_that_vanishes_at_rest_is_divided_by_its_state(name: str) -> None:
    """Monod's s/(k + s) less its value at rest, over s: 1/(k + s) serves everywhere, 3 premises."""
    model = model_of(name)

    assert len(model.premises) == 3
    for premise in model.premises:
        assert premise.evaluate is not None
        value = premise.evaluate(**{f"delta_{v.name}": 0.0 for v in plant(name).states})
        assert premise.lower <= value <= premise.upper


def test_a_rest_that_is_solved_for_makes_no_rules() -> None:
    """Khalil's coil: its rest is solved for, and is a number of the entries, no premise."""
    model = model_of("magnetic_levitation")
    widths = [float(z.upper - z.lower) for z in model.premises]

    assert len(model.A) == 16 and min(widths) > 1e-2


def is_proved_and_settles(name: str) -> None:
    made = design_plant(plant(name))
    assert not isinstance(made, NoDesign)
    assert made.proved
    loop = textbook_loop(FILES[name], made.document)
    n = len(loop.states)
    still = loop.rate(loop.rest[:n], loop.rest[n:])
    assert np.all(np.abs(still) * loop.horizon <= 1e-9 * loop.reach)
    for start in loop.boundary():
        motion = loop.run(start)
        assert loop.level(motion).max() <= 1
        assert loop.settled(motion) is not None


@pytest.mark.parametrize("name", QUICK)
def test_a_quick_plant_is_proved_and_settles(name: str) -> None:
    """From both ends of all axes of the certified set, with inputs cut at their ranges."""
    is_proved_and_settles(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(PROVED) - set(QUICK)))
def test_a_plant_is_proved_and_settles(name: str, reduced: bool) -> None:
    """The same for the others, which take five to thirty seconds each; reduced, for half of them.

    The fermenter, whose identity the checker alone shows, and the helicopter are always in.
    """
    if reduced and name not in REDUCED:
        pytest.skip("the whole gallery takes minutes: without TAKAGI_REDUCED")
    is_proved_and_settles(name)


@pytest.mark.parametrize("file", TURBINES, ids=lambda file: file.stem)
def test_a_turbine_of_public_files_is_read(file: Path) -> None:
    """Nothing but what its files have: no reference controller, a frozen wake by the rule."""
    turbine = load_turbine(file)
    check_limits(turbine, default_settings(turbine))

    assert turbine.baseline is None and "computed" in turbine.frozen_wake.source
    assert f"[{turbine.name}](../tests/gallery/turbines/{file.name}) | PROVED |" in PAGE


def test_a_band_that_just_fits_into_the_table_is_bounded() -> None:
    """From the lowest wind: over a piece of wind, speed and wind do not meet at their ends."""
    turbine = load_turbine(HERE / "turbines" / "nrel2p8.toml")
    first = lowest_wind(turbine, speed_band="0.1", wind_band="0.5")

    assert len(partial_load_model(turbine, wind_range=(first, first + 0.25)).rules) == 4


@pytest.mark.slow
@pytest.mark.parametrize("file", TURBINES, ids=lambda file: file.stem)
def test_a_turbine_of_public_files_is_proved(file: Path, reduced: bool) -> None:
    """Its loop without the observer, and the claims that follow; a cut of the set is not."""
    if reduced and file != TURBINES[0]:
        pytest.skip("reduced: one of them")
    document = turbine_claims(file).document

    assert len(document["claims"]) == 3
    assert check_document(document).verdict is Verdict.PROVED
    document["claims"][0]["cells"][30]["wind_error"] *= 1.1
    assert check_document(resealed(document)).verdict is not Verdict.PROVED
