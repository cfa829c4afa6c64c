"""Breaks the checker's own lines, one at a time, and counts which the tests notice.

    python benchmarks/checker_lines.py [--count N] [--seed N] [--only TEXT] [--wide] [--seconds S]

A comparison is turned or loses its equality, a sign, an operator or a constant changes, a guard is
left out, ``and`` becomes ``or``, ``min`` becomes ``max``, a transpose is dropped.  Every broken
module is imported in a process of its own, where the tests of that module run until one fails, and
then those that throw known problems at the checker; ``--wide`` adds all that are about its part.
Survivors are printed with their lines: each is equivalent, stricter than needed, or a test that is
missing.  The table goes to docs/benchmarks.md.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import os
import random
import signal
import sys
import time
from collections.abc import Iterator
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from itertools import islice
from pathlib import Path
from types import ModuleType
from typing import NamedTuple

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from measure import PAGE, placed, table  # noqa: E402  the threads are counted first

ROOT = Path(__file__).resolve().parents[1]
CHECKER, TESTS = ROOT / "certificates" / "checker", "tests/certificates"
LONGEST = 240.0
KERNEL = ("definite", "matrices", "family")
# Heavy, and not what is tested: imported once, before the processes part.
PRELOADED: tuple[str, ...] = (
    *("numpy", "scipy.linalg", "scipy.sparse", "scipy.optimize", "pytest"),
    *("sympy", "clarabel", "flint", "takagi.models.ts_model", "takagi.lmi.answer"),
)
# Tests of modules without a file of tests by their own name.
BESIDE = {
    "invariant_set": ("invariant_ellipsoid", "peak"),
    "disturbed_path": ("l2_gain", "h2_norm"),
    "box_of_validity": ("invariant_ellipsoid", "input_limits"),
    "exponential": ("decay", "transient"),
    "ellipsoid_size": ("invariant_ellipsoid",),
    "input_rate": ("input_limits",),
    "no_common_decay": ("no_common_decay", "decay", "quadratic", "thresholds"),
    "certificate": ("document", "damaged_files"),
}
TURNED: dict[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt),
    ast.LtE: (ast.Lt, ast.GtE),
    ast.Gt: (ast.GtE, ast.Lt),
    ast.GtE: (ast.Gt, ast.LtE),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}
OTHER: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Add,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.Pow: ast.Mult,
}
SWAPPED = {"min": "max", "max": "min", "all": "any", "any": "all", "at_least": "at_most"}
SWAPPED |= {"at_most": "at_least", "exp_below": "exp_above", "exp_above": "exp_below"}
SWAPPED |= {"is_positive_definite": "is_symmetric", "is_positive_semidefinite": "is_symmetric"}


class Broken(NamedTuple):
    """A module with one change."""

    module: Path
    line: int
    what: str
    tree: ast.Module


def main() -> int:
    """Break so many lines, print survivors and the table, and write it into the page."""
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("--count", type=int, default=300, help="lines to break, drawn from all")
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--only", default="", help="modules whose path has this in it")
    reader.add_argument("--wide", action="store_true", help="try survivors on all of their part")
    reader.add_argument("--seconds", type=float, default=float("inf"), help="stop after these")
    reader.add_argument("--print-only", action="store_true", help="leave the page as it is")
    asked = reader.parse_args()
    os.chdir(ROOT)
    for name in PRELOADED:
        importlib.import_module(name)
    modules = [path for path in targets() if asked.only in str(path.relative_to(CHECKER))]
    every = [(path, k) for path in modules for k in range(changes_in(path))]
    rng = random.Random(asked.seed)
    # Every part of the checker in turn, so that a run that is cut short has seen all of them.
    parts: dict[str, list[tuple[Path, int]]] = {}
    for path, k in rng.sample(every, len(every)):
        parts.setdefault(part_of(path), []).append((path, k))
    seen = {part: [len(listed), 0, 0] for part, listed in parts.items()}
    start = time.perf_counter()
    for k in range(asked.count):
        listed = list(parts.values())[k % len(parts)]
        if not listed or time.perf_counter() - start > asked.seconds:
            continue
        broken = broken_module(*listed.pop())
        counts = seen[part_of(broken.module)]
        counts[1] += 1
        if survives(broken, wide=asked.wide):
            place = broken.module.relative_to(ROOT)
            print(f"survives: {place}:{broken.line}: {broken.what}", flush=True)
        else:
            counts[2] += 1
    rows = [
        (part, str(sites), str(tried), str(killed), f"{100 * killed / max(tried, 1):.0f} %")
        for part, (sites, tried, killed) in sorted(seen.items())
    ]
    text = table(("part of the checker", "changes", "tried", "noticed", "share"), rows)
    print(text)
    if not asked.print_only:
        PAGE.write_text(placed(PAGE.read_text(encoding="utf-8"), "checker lines", text), "utf-8")
    return 0


def targets() -> list[Path]:
    """Return the modules that are broken: the kernel, claims by kind, the plant's reading."""
    kernel = [CHECKER / "kernel" / f"{name}.py" for name in (*KERNEL, "certificate")]
    return [*kernel, *sorted(CHECKER.glob("kinds/*.py")), *sorted(CHECKER.glob("plant/*.py"))]


def part_of(module: Path) -> str:
    folder = module.parent.name
    return "kernel" if folder == "kernel" else f"{folder}/"


def tests_of(module: Path, *, wide: bool = False) -> list[list[str]]:
    """Return the tests in stages: of the module's own part, then all about certificates."""
    stem, part = module.stem, part_of(module)
    if part == "plant/":
        names = ["wrong_embeddings", "identities", "ranges", "elementary_functions", "plant_file"]
        first = [f"{TESTS}/embedding/test_{name}.py" for name in names]
        return [first, [f"{TESTS}/embedding", f"{TESTS}/test_plant_design.py"]][: 1 + wide]
    names = [*BESIDE.get(stem, ()), stem]
    own = [f"{TESTS}/kinds/test_{name}.py" for name in names]
    own += [f"{TESTS}/test_{name}.py" for name in names]
    stages = [
        [path for path in own if Path(path).exists()],
        [f"{TESTS}/campaigns/test_soundness.py", f"{TESTS}/kinds/test_unstable_loops.py"],
        [f"{TESTS}/kinds", *(f"{TESTS}/test_{n}.py" for n in (*KERNEL, "quadratic", "thresholds"))],
    ]
    return [stage for stage in stages[: 2 + wide] if stage]


# ------------------------------------------------------------------ changes


def broken_modules(path: Path) -> Iterator[Broken]:
    """Yield the module with each change that is known; strings and annotations stay."""
    for k in range(changes_in(path)):
        yield broken_module(path, k)


def changes_in(path: Path) -> int:
    """Return how many changes are known for a module."""
    return sum(1 for _ in _sites(ast.parse(path.read_text(encoding="utf-8"))))


def broken_module(path: Path, k: int) -> Broken:
    """Return the module with its change number k."""
    tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
    node, what = next(islice(_sites(tree), k, None))
    line = getattr(node, "lineno", 0)
    before = ast.unparse(node).splitlines()[0]
    _change(node, what)
    after = ast.unparse(node).splitlines()[0]
    return Broken(path, line, f"{before}  ->  {after}", ast.fix_missing_locations(tree))


def _sites(tree: ast.AST) -> Iterator[tuple[ast.AST, str]]:
    """Yield (node, change) in order."""
    for node in _reached(tree):
        if isinstance(node, ast.Compare):
            yield from (
                (node, f"compare {i}") for i in range(len(TURNED.get(type(node.ops[0]), ())))
            )
        elif isinstance(node, ast.BinOp) and type(node.op) in OTHER:
            yield node, "operator"
        elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            yield node, "order"
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not)):
            yield node, "sign"
        elif isinstance(node, ast.BoolOp):
            yield node, "junction"
        elif isinstance(node, ast.Constant) and type(node.value) in (int, bool):
            yield node, "constant"
        elif isinstance(node, ast.If):
            yield node, "guard"
        elif isinstance(node, ast.Name) and node.id in SWAPPED and isinstance(node.ctx, ast.Load):
            yield node, "name"
        elif isinstance(node, ast.Attribute) and (node.attr == "T" or node.attr in SWAPPED):
            yield node, "attribute"


def _reached(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes that decide something: no annotations, no words, no limits of size."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list"):
            continue
        if isinstance(node, ast.Raise) or isinstance(value, ast.JoinedStr):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, (ast.JoinedStr, ast.Raise, ast.Import, ast.ImportFrom)):
                continue
            if isinstance(child, ast.Assign) and isinstance(node, ast.Module):
                continue
            if isinstance(child, ast.AST):
                yield child
                yield from _reached(child)


def _change(node: ast.AST, what: str) -> None:
    if isinstance(node, ast.Compare):
        node.ops[0] = TURNED[type(node.ops[0])][int(what.split()[1])]()
    elif isinstance(node, ast.BinOp):
        if what == "order":
            node.left, node.right = node.right, node.left
        else:
            node.op = OTHER[type(node.op)]()
    elif isinstance(node, ast.UnaryOp):
        # Twice is never: matrices have no unary plus.
        node.operand = ast.UnaryOp(type(node.op)(), node.operand)
    elif isinstance(node, ast.BoolOp):
        node.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
    elif isinstance(node, ast.Constant):
        node.value = not node.value if isinstance(node.value, bool) else int(str(node.value)) + 1
    elif isinstance(node, ast.If):
        node.test = ast.Constant(False)
    elif isinstance(node, ast.Name):
        node.id = SWAPPED[node.id]
    elif isinstance(node, ast.Attribute):
        if node.attr == "T":
            node.value = ast.Attribute(node.value, "T", ast.Load())
        else:
            node.attr = SWAPPED[node.attr]


# ------------------------------------------------------------------ one broken module


class Breaker(MetaPathFinder, Loader):
    """Imports one module from a changed tree."""

    def __init__(self, broken: Broken) -> None:
        place = broken.module.relative_to(ROOT).with_suffix("")
        self.name = ".".join(("takagi", *place.parts))
        self.code = compile(broken.tree, str(broken.module), "exec")

    def find_spec(
        self, fullname: str, path: object = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        return ModuleSpec(fullname, self) if fullname == self.name else None

    def exec_module(self, module: ModuleType) -> None:
        exec(self.code, module.__dict__)


def survives(broken: Broken, *, wide: bool) -> bool:
    """Return whether no test notices; one that runs for minutes has noticed."""
    return all(_passes(broken, tests) for tests in tests_of(broken.module, wide=wide))


def _passes(broken: Broken, tests: list[str]) -> bool:
    child = os.fork()
    if child == 0:
        os.setpgid(0, 0)
        _test(broken, tests)
    deadline = time.monotonic() + LONGEST
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status) == 0
        time.sleep(0.05)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return False


def _test(broken: Broken, tests: list[str]) -> None:
    """Run the tests in this process, which is a copy, and end it with their status."""
    import pytest

    code = 1
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        sys.meta_path.insert(0, Breaker(broken))
        code = int(pytest.main([*tests, "-x", "-q", "-p", "no:cacheprovider"]))
    finally:
        os._exit(code)


if __name__ == "__main__":
    raise SystemExit(main())
