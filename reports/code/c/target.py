"""`takagi export --to c`: the law as C99 with a self-test, an example and a README."""

from __future__ import annotations

from takagi.reports.code.c.accompanying_files import example, page, self_test
from takagi.reports.code.c.source import c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.targets import Exported, ExportSettings


def export(program: ControllerProgram, settings: ExportSettings) -> Exported:
    """Return ``W.h``, ``W.c``, ``W_test.c``, ``W_example.c`` and ``README.md``.

    Raises
    ------
    ModelError : a name, number or sample time that C or the law cannot hold.
    """
    c = c_source(program, settings)
    word = c.word
    files = {
        f"{word}.h": c.header,
        f"{word}.c": c.source,
        f"{word}_test.c": self_test(program, c, settings),
        f"{word}_example.c": example(program, c, settings),
        "README.md": page(program, c, settings),
    }
    use = {
        f"{word}.c": f"compile it: cc -std=c99 -O2 -ffp-contract=off -c {word}.c",
        f"{word}.h": f"{word}_init once, {word}_step at every sample",
        f"{word}_test.c": f"try it: cc {word}.c {word}_test.c -lm && ./a.out",
        f"{word}_example.c": "a loop with every call",
        "README.md": "inputs, outputs, units and status bits",
    }
    return Exported(files, use)
