"""Feeds the checker damaged certificates, guided by the lines they reach, and looks for crashes.

    python benchmarks/fuzz_checker.py [--seconds N] [--seed N] [--keep DIR] [--small]

Starts from a recorded certificate of every kind, and from models with their files, changes their
trees, texts and files (``fuzz_mutations``), most of them with matching hashes so that the change is
looked at, and keeps what takes the checker from one line to another in a way not seen before.  A
crash is any exception but CertificateError, more than ``LONGEST`` seconds or ``MEMORY`` bytes for
one file, a sentence that is not printable or too long, a report that its reader cannot parse.  The
exit status is 1 when there was one; ``--keep`` names the folder that it is written to.

Whether a verdict is true is not asked here: benchmarks/soundness.py and mutations.py do.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
import xml.etree.ElementTree as ElementTree
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from fuzz_mutations import damaged_text, damaged_tree, resealed, without_content

from takagi.certificates import checker
from takagi.certificates.checker import CertificateError, check
from takagi.certificates.checker.kernel.reader import Number, canonical, read_text
from takagi.reports import ci_formats

CERTIFICATE, GAINS = "certificate.json", "gains.json"
RECORDED = Path(__file__).resolve().parents[1] / "tests" / "certificates" / "recorded"
# Characters of a certificate that is no turbine's loop.
SMALL = 20_000
LONGEST, MEMORY = 60.0, 2_000_000_000
MOST_WORDS = 20_000
# Of each function, so many calls of one run are followed line by line, and this share of the rest.
FOLLOWED, SHARE = 8, 0.02
SLOW = 0.5  # seconds: what takes longer is not built upon
CHECKER = str(Path(str(checker.__file__)).parent)


class TooLongError(BaseException):
    """One file took too long; no handler of the checker may take it for its own."""


class BadAnswerError(Exception):
    """The checker's answer cannot be shown."""


@dataclass
class Edges:
    """Pairs of lines (one after the other, in one function) that have been run."""

    rng: random.Random
    seen: set[tuple[CodeType, int, int]] = field(default_factory=set)
    new: int = 0
    calls: Counter[CodeType] = field(default_factory=Counter)

    def start(self) -> None:
        self.new = 0
        self.calls.clear()
        sys.settrace(self._call)

    def stop(self) -> int:
        """Return how many edges the run has added."""
        sys.settrace(None)
        return self.new

    def _call(self, frame: FrameType, event: str, _: Any) -> Any:
        code = frame.f_code
        if not code.co_filename.startswith(CHECKER):
            return None
        self.calls[code] += 1
        if self.calls[code] > FOLLOWED and self.rng.random() > SHARE:
            return None
        last = 0

        def line(frame: FrameType, event: str, _: Any) -> Any:
            nonlocal last
            if event == "line":
                edge = code, last, frame.f_lineno
                last = frame.f_lineno
                if edge not in self.seen:
                    self.seen.add(edge)
                    self.new += 1
            return line

        return line


@dataclass(frozen=True)
class Case:
    """A folder's worth of files; ``tree`` is the certificate's, None where it is no tree."""

    origin: str
    files: dict[str, str]
    tree: Any
    with_gains: bool = False
    model: str = ""


def seeds(*, small: bool) -> list[Case]:
    """Return the shortest proved certificate of every kind, and models with their files.

    ``small`` leaves out the turbines' loops, which take longer.
    """
    cases = []
    for place in sorted(RECORDED.glob("*.jsonl")):
        answers = map(json.loads, place.read_text(encoding="utf-8").splitlines())
        proved = [text for answer, text, *_ in answers if answer[0] == ["PROVED"]]
        if proved and not (small and len(min(proved, key=len)) > SMALL):
            cases.append(_case(place.stem, read_text(min(proved, key=len), "seed"), {}))
    recorded = (RECORDED / "model_files.json").read_text(encoding="utf-8")
    for name, parts in read_text(recorded, "seeds").items():
        files = parts.pop("files")
        tree = {"format": "takagi-certificate", "version": Number("1"), **parts}
        cases.append(_case(name, resealed(tree), files))
    return cases


def _case(origin: str, tree: Any, files: dict[str, str]) -> Case:
    gains = {GAINS: canonical({"law": tree.get("gains")})}
    model = next((name for name in files if name.endswith(".toml")), "")
    return Case(origin, {CERTIFICATE: canonical(tree), **gains, **files}, tree, False, model)


def main() -> int:
    """Run the campaign and print what it found."""
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("--seconds", type=float, default=600.0)
    reader.add_argument("--seed", type=int, default=1)
    reader.add_argument("--keep", type=Path, help="where crashes are written")
    reader.add_argument("--small", action="store_true", help="start without the turbines' loops")
    asked = reader.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        campaign = Campaign(asked.seed, Path(scratch), asked.keep)
        campaign.run(seeds(small=asked.small), asked.seconds)
    print(campaign.summary(asked.seed))
    return 1 if campaign.crashes else 0


class Campaign:
    """One run: the corpus it builds, and what it counts."""

    def __init__(self, seed: int, scratch: Path, keep: Path | None) -> None:
        self.rng, self.scratch, self.keep = random.Random(seed), scratch, keep
        self.edges = Edges(random.Random(seed + 1))
        self.corpus: list[tuple[Case, float]] = []
        self.crashes: dict[str, int] = {}
        self.outcomes: Counter[str] = Counter()
        self.first = self.executions = 0
        self.slowest = self.took = 0.0

    def run(self, seeds: list[Case], seconds: float) -> None:
        """Try the seeds, then damaged ones until the time is over."""
        begun = told = time.monotonic()
        for case in seeds:
            for way in (case, Case(case.origin, case.files, case.tree, True, case.model)):
                self._try(way, always=True)
        self.first = len(self.edges.seen)
        while (now := time.monotonic()) - begun < seconds:
            if now - told > 60:
                told = now
                print(f"{now - begun:.0f} s: {self._counts()}", file=sys.stderr, flush=True)
            self._try(self._damaged(), always=False)
        self.took = time.monotonic() - begun

    def _damaged(self) -> Case:
        rng = self.rng
        # Half of the time something found lately.
        recent = self.corpus[-50:] if rng.random() < 0.5 else self.corpus
        weights = [1 / (0.01 + seconds) for _, seconds in recent]
        case = rng.choices(recent, weights)[0][0]
        files, tree, way = dict(case.files), case.tree, rng.random()
        with_gains, model = rng.random() < 0.15, case.model if rng.random() < 0.15 else ""
        if way < 0.1 or tree is None:
            files[CERTIFICATE] = damaged_text(files[CERTIFICATE], rng)
            return Case(case.origin, files, None, with_gains, model)
        if model and way < 0.6:
            name = rng.choice([name for name in files if name not in (CERTIFICATE, GAINS)])
            files[name] = damaged_text(files[name], rng)
            tree = without_content(tree)
        elif with_gains and way < 0.6:
            files[GAINS] = damaged_text(files[GAINS], rng)
        else:
            tree = damaged_tree(tree, rng.choice(self.corpus)[0].tree or tree, rng)
        sealed = resealed(tree) if rng.random() < 0.97 else tree
        files[CERTIFICATE] = canonical(sealed)
        return Case(case.origin, files, sealed, with_gains, model or case.model)

    def _try(self, case: Case, *, always: bool) -> None:
        shutil.rmtree(self.scratch, ignore_errors=True)
        self.scratch.mkdir(parents=True)
        for name, text in case.files.items():
            if name == CERTIFICATE or (name == GAINS and case.with_gains) or case.model:
                (self.scratch / name).write_bytes(text.encode(errors="surrogatepass"))
        begun = time.monotonic()
        self.edges.start()
        try:
            outcome = self._outcome(case)
        finally:
            new = self.edges.stop()
        took = time.monotonic() - begun
        self.executions += 1
        self.outcomes[outcome] += 1
        self.slowest = max(self.slowest, took)
        if always or (new and took < SLOW):
            self.corpus.append((case, took))

    def _outcome(self, case: Case) -> str:
        folder, before = self.scratch, _limited()
        signal.setitimer(signal.ITIMER_REAL, LONGEST)
        try:
            checked = check(
                folder / CERTIFICATE,
                gains=folder / GAINS if case.with_gains else None,
                model=folder / case.model if case.model and case.with_gains else None,
            )
            _shown(checked)
        except CertificateError as error:
            if len(str(error)) > MOST_WORDS:
                self._crash(case, BadAnswerError(f"{len(str(error))} characters of refusal"))
            return "refused"
        except (Exception, TooLongError) as error:
            self._crash(case, error)
            return "crash"
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            resource.setrlimit(resource.RLIMIT_AS, before)
        return str(checked.verdict.name)

    def _crash(self, case: Case, error: BaseException) -> None:
        sys.settrace(None)
        place = traceback.extract_tb(error.__traceback__)[-1:]
        at = f"{Path(place[0].filename).name}:{place[0].lineno}" if place else ""
        what = f"{type(error).__name__} {at}"
        self.crashes[what] = self.crashes.get(what, 0) + 1
        if self.crashes[what] > 1:
            return
        print(f"crash: {what}: {str(error)[:300]} (from {case.origin})", file=sys.stderr)
        if self.keep is not None:
            folder = self.keep / hashlib.sha256(what.encode()).hexdigest()[:12]
            folder.mkdir(parents=True, exist_ok=True)
            for name, text in case.files.items():
                (folder / name).write_bytes(text.encode(errors="surrogatepass"))
            (folder / "why.txt").write_text("".join(traceback.format_exception(error)))

    def _counts(self) -> str:
        new = len(self.edges.seen) - self.first
        return (
            f"{self.executions} executions, {self.first} edges of the seeds, {new} new, "
            f"{len(self.corpus)} kept, {len(self.crashes)} crashes, slowest {self.slowest:.1f} s"
        )

    def summary(self, seed: int) -> str:
        """Return what was run and found, as text."""
        outcomes = ", ".join(f"{name} {count}" for name, count in self.outcomes.most_common())
        lines = [f"seed {seed}, {self.took:.0f} s: {self._counts()}", f"outcomes: {outcomes}"]
        return "\n".join([*lines, *(f"{what}: {n} times" for what, n in self.crashes.items())])


def _shown(checked: Any) -> None:
    """Show an answer in every form there is, and read those back that have a reader."""
    ElementTree.fromstring(ci_formats.junit(checked, source="certificate.json"))
    json.loads(ci_formats.sarif(checked, source="certificate.json"))
    ci_formats.markdown(checked, source="certificate.json")
    for words in (*(part for c in checked.claims for part in (c.name, c.text)), *checked.messages):
        if not words.isprintable() or len(words) > MOST_WORDS:
            raise BadAnswerError(f"{len(words)} characters: {words[:200]!a}")


def _limited() -> tuple[int, int]:
    """Bound the memory of this process; return the bounds there were."""
    before = resource.getrlimit(resource.RLIMIT_AS)
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, before[1]))
    return before


def too_long(*_: object) -> None:
    """End a check that takes too long; for SIGALRM."""
    raise TooLongError(f"more than {LONGEST:.0f} s")


if __name__ == "__main__":
    signal.signal(signal.SIGALRM, too_long)
    sys.exit(main())
