"""`takagi appendix`: the design as LaTeX, to compile alone or to take into a paper."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from shutil import which

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Folder
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import progress
from takagi.reports.output import write_folder

_MAIN, _BODY, _BIB, _FIGURES = "appendix.tex", "appendix-body.tex", "appendix.bib", "figures"

_NO_TEX = (
    "pdflatex is not installed here: apt install texlive-latex-extra texlive-fonts-recommended, or "
    "take the folder to an online LaTeX editor"
)


def appendix(folder: Folder, out: Path, *, as_json: bool = False) -> int:
    """Write the LaTeX appendix of the design in DIR; nothing is designed again."""
    require_folder_place(out, files=[_MAIN, _BODY, _BIB], folders=[_FIGURES])
    from takagi.reports.design_folder import appendix_files, read_design

    with progress(f"takagi appendix {folder}") as tell:
        finished = read_design(folder, tell=tell)
        files = appendix_files(finished, tell=tell)
        tell(f"writing {out}")
        write_folder(out, files)
    _print(finished.verdict_words, out, list(files), as_json=as_json)
    return PROVED if finished.proved else UNPROVED


run = partial(run_command, "appendix", appendix)


def _print(verdict: str, out: Path, names: list[str], *, as_json: bool) -> None:
    if as_json:
        print(json.dumps({"verdict": verdict, "files": [str(out / n) for n in names]}, indent=2))
        return
    figures = sum(name.startswith(f"{_FIGURES}/") for name in names)
    print(f"{out / _MAIN}: {verdict}, {figures} figures")
    run = f"pdflatex {_MAIN}"
    print(f"\nCompile\n  cd {out} && {run} && bibtex appendix && {run} && {run}")
    if which("pdflatex") is None:
        print(f"  {_NO_TEX}")
    print(f"Take into a paper\n  \\input{{{_BODY.removesuffix('.tex')}}}, and {_BIB} among its "
          "references; the first lines name the packages")  # fmt: skip
