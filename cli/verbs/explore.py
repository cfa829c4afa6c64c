"""`takagi explore`: a page on which a plant's requirements, or a turbine's wind, are turned."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.plant_options import plant_settings, time_asked
from takagi.cli.options.turbine_options import ModelOrFolder
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import progress
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.reports.explore.books import Book


def explore(
    model: ModelOrFolder,
    port: int = 0,
    timeout: str | None = None,
    cache: Path | None = None,
    no_browser: bool = False,
) -> int:
    """Open a page on which the requirements of MODEL are turned, and the proved design follows."""
    try:
        from takagi.reports.explore.server import bound_socket, serve
    except ImportError as error:
        if error.name not in ("starlette", "uvicorn"):
            raise
        raise ModelError(
            f"the page needs {error.name}, which is not installed: pip install 'takagi[explore]'"
        ) from error
    seconds = None if timeout is None else time_asked("--timeout", timeout, positive=True)
    # Before the first design, which may take long.
    listening = bound_socket(port)
    with listening:
        book = _book(model, cache)
        if isinstance(book, str):
            print(f"{model}: its file has no design, so that there is nothing to turn.\n{book}")
            return UNPROVED
        serve(book, listening, ready=partial(_announce, no_browser=no_browser), seconds=seconds)
    return PROVED


def _announce(address: str, *, no_browser: bool) -> None:
    print(f"{address}\nCtrl-C ends the page.", flush=True)
    if not no_browser and sys.stdout.isatty():
        import webbrowser

        webbrowser.open(address)


def _book(model: str, cache: Path | None) -> Book | str:
    """Return what the page shows; why there is no design."""
    from takagi.models.loading import read_model
    from takagi.models.plant_files.loader import PlantFile
    from takagi.reports.design_folder import design_folder, read_design

    name, folder = model, Path(model)
    if folder.is_dir():
        copied = design_folder(folder).model
        source = read_model(copied)
        if source.kind == "turbine":
            from takagi.certificates.design.turbine.result import TurbineDesign
            from takagi.reports.explore.turbine_cells import turbine_book

            with progress(f"takagi explore {model}") as tell:
                design = read_design(folder, tell=tell)
            assert isinstance(design, TurbineDesign)  # its model is one
            return turbine_book(design, folder)
        name = str(copied)
    source = read_model(name)
    if not isinstance(source, PlantFile):
        raise ModelError(
            f"{model} is a wind turbine, whose design takes minutes: make one with 'takagi design "
            f"{model} --out DIR', and explore DIR"
        )
    from takagi.reports.explore.books import cache_folder, plant_book

    require_folder_place(cache_folder(source, cache))
    with progress(f"takagi explore {model}: the first design"):
        return plant_book(source, plant_settings, cache)


run = partial(run_command, "explore", explore)
