"""One real design for all tests of the verbs, and a folder writer that draws nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from takagi.reports import design_folder
from tests.cli.cubic import CUBIC
from tests.undrawn import unmeasured

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign
    from takagi.certificates.design.plant.result import PlantDesign

Files = dict[str, bytes | str]


def contents(folder: Path) -> dict[str, bytes]:
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


@pytest.fixture(scope="session")
def finished(turbine_design: TurbineDesign) -> TurbineDesign:
    return turbine_design


def drawn(_: object, *, tell: Callable[..., None] | None = None) -> Files:
    """A report and its figures, replaced by a word: they are tested elsewhere."""
    if tell is not None:
        tell("report")
    return {"report.html": "<!doctype html><title>report</title>", "figures/bode.svg": b"<svg/>"}


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(design_folder, "report_files", drawn)
    unmeasured(monkeypatch)


@pytest.fixture
def stable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the loop that runs be stable, without five seconds of looking."""
    monkeypatch.setattr("takagi.reports.margins.running_stability.require_stable", lambda *_: ())


@pytest.fixture(scope="module")
def proved_once() -> Iterator[None]:
    """Let `simulate --gains` prove the same gains on the same plant once in a file of tests."""
    from takagi.cli.runs.plant import PlantMaker

    proofs: dict[tuple[object, ...], PlantDesign] = {}
    with_gains = PlantMaker.with_gains

    def proof_of(maker: PlantMaker, gains: Path, tell: Any) -> PlantDesign:
        texts = [path.read_bytes() for path in (*maker.source.files, gains)]
        key = (*texts, repr(sorted(maker.asked.items())))
        if key not in proofs:
            proofs[key] = with_gains(maker, gains, tell)
        return proofs[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(PlantMaker, "with_gains", proof_of)
        yield


@pytest.fixture(scope="module")
def given_observer() -> Iterator[None]:
    """Let the laws of a study have an observer whose gains nobody had to seek."""
    from takagi.models.turbine.loader import load_turbine
    from takagi.models.turbine.wind_observer import WindObserver
    from takagi.reports.simulation import laws
    from takagi.reports.study import overlap

    with pytest.MonkeyPatch.context() as patch:
        observer = WindObserver(load_turbine("nrel5mw"), 1.8, 49.0)
        patch.setattr(laws, "studied_observer", lambda *_: observer)
        yield
    overlap.studied_law.cache_clear()


@pytest.fixture
def asked(
    finished: TurbineDesign, undrawn: None, stable: None, monkeypatch: pytest.MonkeyPatch
) -> Mapping[str, Any]:
    """Let the verbs meet the finished design; the mapping holds what they asked for."""
    from takagi.certificates.design.turbine import design as turbine_design

    seen: dict[str, Any] = {}

    def design_turbine(turbine: Any, settings: Any, *, files: Any, tell: Any) -> TurbineDesign:
        tell("gains")
        seen.update(turbine=turbine, settings=settings, files=files)
        return finished

    monkeypatch.setattr(turbine_design, "design_turbine", design_turbine)
    return seen


@pytest.fixture
def cubic(tmp_path: Path) -> Path:
    """A plant file: x' = x + x^3 + u on |x| <= 1, whose vertices are 1 and 2."""
    path = tmp_path / "cubic.toml"
    path.write_text(CUBIC, encoding="utf-8")
    return path
