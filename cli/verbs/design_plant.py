"""`takagi design` for a plant: the folder, and what is said on the terminal."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.progress import progress
from takagi.cli.runs.plant import plant_asked
from takagi.cli.runs.turbine import Unprovable

__all__ = ["design_plant_folder"]


def design_plant_folder(model: str, out: Path, options: Mapping[str, Any], *, as_json: bool) -> int:
    """Design, write the folder, print the summary; return the exit status."""
    with progress(f"takagi design {model}") as tell:
        finished = plant_asked(model, tell, options)
        if isinstance(finished, Unprovable):
            return finished.tell(as_json=as_json)
        from takagi.reports.output import write_folder
        from takagi.reports.plant_folder import plant_files

        files = plant_files(finished, tell=tell)
        tell(f"writing {out}")
        write_folder(out, files)
    from takagi.cli.terminal.plant_summary import as_data, as_text

    if as_json:
        written = [str(out / name) for name in files]
        print(json.dumps({**as_data(finished), "files": written}, indent=2))
    else:
        from takagi.cli.verbs.design import print_files

        print(as_text(finished))
        print_files(out, files)
        companion = f" --gains {out / 'gains.json'}" if "gains.json" in files else ""
        own = f" --model {model}" if Path(model).suffix == ".toml" else ""
        print(f"\nNext\n  takagi check {out / 'certificate.json'}{companion}{own}")
        if companion:
            print(f"  takagi simulate {model}{companion} --out {out / 'simulation'}")
    return PROVED if finished.proved else UNPROVED
