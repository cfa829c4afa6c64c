"""The list of files that a design wrote, and the message where there is no design."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from takagi.cli.errors import UNPROVED

if TYPE_CHECKING:
    from takagi.certificates.design.design import NoDesign

# File or folder -> its purpose; `figures` is a folder with several files.
PURPOSES = {
    "gains.json": "the law to load into a controller: schedule, gains, limits, units",
    "certificate.json": "the claims with every number that proves them",
    "report.html": "model, gains, margins, poles and responses, to read in a browser",
    "figures": "the report's figures, one file each",
}
FOLDERS = ("figures",)


def print_files(out: Path, files: Mapping[str, bytes | str]) -> None:
    """Print what was written, one line for each file or folder with its purpose."""
    print(f"\n{out}")
    width = max(map(len, PURPOSES)) + 2
    for name, purpose in PURPOSES.items():
        if name in FOLDERS:
            count = sum(file.startswith(f"{name}/") for file in files)
            if count:
                print(f"  {name + '/':<{width}}{purpose} ({count})")
        elif name in files:
            print(f"  {name:<{width}}{purpose}")


def tell_none(found: NoDesign, *, as_json: bool = False) -> int:
    """Print why there is no design, and return the exit status for it.  Nothing was written."""
    if as_json:
        print(json.dumps({"verdict": "UNDECIDED", "reason": found.reason}, indent=2))
    else:
        print(f"Not proved, nothing written: {found.reason}", file=sys.stderr)
    return UNPROVED
