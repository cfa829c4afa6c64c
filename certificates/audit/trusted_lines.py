"""Count the files and lines of the checker that are executed to reach a verdict.

A *line of code* is a line that is neither blank nor comment nor docstring.  A file of
``certificates/checker/`` is counted with all its lines when the check loads it. For this the
checker is loaded again, even if the process has loaded it before.  A line is *executed* when the
statement that it belongs to has begun. The ``def`` line of a function is executed when the file is
loaded, its body when the function is called.

The methods ``sentence`` and ``figures`` of claim kinds, ``in_words`` of an outcome, and the files
of ``words/`` run after the last verdict is fixed.  They are counted separately.  The interpreter
and the standard library are trusted too.
"""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType, ModuleType
from typing import Any

CHECKER = "takagi.certificates.checker"
FOLDER = Path(__file__).parents[1] / "checker"
WORDS, AFTERWARDS = "words", ("sentence", "figures", "in_words")
Lines = dict[str, set[int]]


@dataclass(frozen=True)
class File:
    """A file of the checker: path in ``certificates/checker/``, lines of code, executed lines."""

    path: str
    lines: int
    executed: int


@dataclass(frozen=True)
class Trusted:
    """Files that a verdict used, and files that wrote its sentences afterwards."""

    files: list[File]
    words: list[File]

    @property
    def lines(self) -> int:
        """Lines of code of the files that the verdict used."""
        return sum(file.lines for file in self.files)

    @property
    def executed(self) -> int:
        """How many of them were executed."""
        return sum(file.executed for file in self.files)


def check_counted(certificate: Path | str, **arguments: Any) -> tuple[Any, Trusted]:
    """Return the verdict on a certificate, as ``check`` does, and the files it used.

    ``arguments`` : the other arguments of ``check``.

    Raises
    ------
    CertificateError : as for ``check``.
    """
    from takagi.certificates.checker import CertificateError

    executed: Lines = {}
    with _loaded_anew():
        refusal: type[Exception] = CertificateError
        try:
            with _followed(executed):
                checker = importlib.import_module(CHECKER)
                refusal = checker.CertificateError
                checked = checker.check(certificate, **arguments)
        except refusal as error:
            # The caller can only catch the exception class that was loaded before.
            raise CertificateError(str(error)) from error
        loaded = [module for name, module in sorted(sys.modules.items()) if _is_checker(name)]
        counted = [_counted(module, executed) for module in loaded]
    files = [file for file, _ in counted if file.lines and not file.path.startswith(f"{WORDS}/")]
    words = [file for file, _ in counted if file.path.startswith(f"{WORDS}/")]
    return checked, Trusted(
        files, [*words, *(sentences for _, sentences in counted if sentences.lines)]
    )


def code_lines(source: str) -> set[int]:
    """Return the numbers of the lines of a module that are code."""
    words: set[int] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            words |= set(range(node.lineno, (node.end_lineno or node.lineno) + 1))
    return {
        number
        for number, line in enumerate(source.splitlines(), start=1)
        if line.strip() and not line.strip().startswith("#") and number not in words
    }


def _is_checker(name: str) -> bool:
    return name == CHECKER or name.startswith(f"{CHECKER}.")


@contextmanager
def _loaded_anew() -> Iterator[None]:
    """Remove the checker's modules temporarily, so that the check loads only what it needs."""
    modules = {name: sys.modules.pop(name) for name in list(sys.modules) if _is_checker(name)}
    owner = sys.modules[CHECKER.rpartition(".")[0]]
    try:
        yield
    finally:
        for name in list(sys.modules):
            if _is_checker(name):
                del sys.modules[name]
        sys.modules.update(modules)
        owner.__dict__["checker"] = modules[CHECKER]


@contextmanager
def _followed(executed: Lines) -> Iterator[None]:
    """Record each line of the checker's files when it is executed."""
    unrecorded: dict[CodeType, set[int]] = {}

    def called(frame: FrameType, _event: str, _value: object) -> Any:
        code = frame.f_code
        if code not in unrecorded:
            inside = Path(code.co_filename).resolve().is_relative_to(FOLDER.resolve())
            unrecorded[code] = {line for *_, line in code.co_lines() if line} if inside else set()
        # A function whose lines were all recorded is no longer traced, which saves time.
        return at_line if unrecorded[code] else None

    def at_line(frame: FrameType, event: str, _value: object) -> Any:
        if event == "line":
            code = frame.f_code
            executed.setdefault(code.co_filename, set()).add(frame.f_lineno)
            unrecorded[code].discard(frame.f_lineno)
            if not unrecorded[code]:
                return None
        return at_line

    previous_trace = sys.gettrace()
    sys.settrace(called)
    try:
        yield
    finally:
        sys.settrace(previous_trace)


def _counted(module: ModuleType, executed: Lines) -> tuple[File, File]:
    """Return the counts of a file without its sentences, and of these alone."""
    path = Path(str(module.__file__))
    source = path.read_text(encoding="utf-8")
    tree, lines = ast.parse(source), code_lines(source)
    recorded = executed.get(str(module.__file__), set())
    owners: dict[int, ast.stmt] = {}
    for node in ast.walk(tree):
        # Inner statements come later, and take their lines over.
        if isinstance(node, ast.stmt):
            owners |= dict.fromkeys(_lines_of(node), node)
    begun = {owners[line] for line in recorded & owners.keys()}
    reached = {line for line, statement in owners.items() if statement in begun}
    sentences = {
        line
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name in AFTERWARDS
        for line in _lines_of(node)
    }
    relative_path = path.resolve().relative_to(FOLDER.resolve()).as_posix()
    verdict, words = lines - sentences, lines & sentences
    return (
        File(relative_path, len(verdict), len(verdict & reached)),
        File(relative_path, len(words), len(words & reached)),
    )


def _lines_of(statement: ast.stmt) -> range:
    """Return the lines of a statement, its decorators and inner statements included."""
    decorators = getattr(statement, "decorator_list", [])
    first = min(node.lineno for node in (statement, *decorators))
    return range(first, (statement.end_lineno or statement.lineno) + 1)
