"""The workflow of continuous integration for a plant's file or a committed design.

Its steps are shell commands, the same for GitHub and GitLab: the base, from the branch that a
change goes to; a design, or the committed one; its check; the comparison of both.
"""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from takagi.models.errors import ModelError

# Kind of service -> the file that it reads, relative to the repository's folder.
FILES = {"github": ".github/workflows/takagi.yml", "gitlab": ".gitlab-ci.yml"}
_OUT, _BASE = "takagi-ci", "takagi-base"
_REPORTS = f"--junit {_OUT}/checks.xml --sarif {_OUT}/checks.sarif --summary {_OUT}/checks.md"


class Step(NamedTuple):
    """A step of the job: shell commands, the first failure of which ends it."""

    name: str
    lines: tuple[str, ...]


class Workflow(NamedTuple):
    """The file to write: where, its text, and what its user should know."""

    path: Path
    text: str
    remarks: tuple[str, ...]


def workflow(service: str, subject: Path) -> Workflow:
    """Return the workflow for a plant's or turbine's file, or for the folder of a design.

    Raises
    ------
    ModelError : another service, or a subject that is no such file and outside of the repository.
    CertificateError : a folder without a certificate.
    """
    if service not in FILES:
        raise ModelError(f"--ci {service}: is not known; {' or '.join(FILES)} is needed")
    root = _repository()
    try:
        place = subject.resolve().relative_to(root).as_posix()
    except ValueError:
        raise ModelError(
            f"{subject}: lies outside of the repository {root}; run the command in the repository "
            "of the plant"
        ) from None
    remarks: tuple[str, ...] = ()
    if subject.is_dir():
        steps, remarks = _of_design(subject, place, root)
    else:
        from takagi.models.loading import load_model

        # A file that `takagi design` would refuse has no use in a workflow.
        load_model(subject)
        steps = _of_plant(place)
    text = (_github if service == "github" else _gitlab)([_base(), *steps], place)
    return Workflow(Path(os.path.relpath(root / FILES[service])), text, remarks)


def _repository() -> Path:
    """Return the folder of the git repository, or the current one outside of any."""
    here = Path.cwd().resolve()
    return next((f for f in (here, *here.parents) if (f / ".git").exists()), here)


def _base() -> Step:
    return Step(
        "base",
        (
            f"rm -rf {_OUT} {_BASE}",
            f"mkdir {_OUT}",
            "git worktree prune",
            "# What the change is compared with: the branch that it goes to.",
            'git fetch --quiet origin "$TARGET"',
            'BASE="$(git rev-parse FETCH_HEAD)"',
            'if [ "$BASE" = "$(git rev-parse HEAD)" ]; then BASE="$BASE^"; fi',
            f'git worktree add --quiet --detach {_BASE} "$BASE" || echo "no earlier commit"',
        ),
    )


def _of_plant(place: str) -> list[Step]:
    """Return the steps that design a plant at each change."""
    file, base = shlex.quote(place), shlex.quote(f"{_BASE}/{place}")
    return [
        Step("design", (f"takagi design {file} --out {_OUT}/now",)),
        Step("check", (f"takagi check {_OUT}/now --model {file} {_REPORTS}",)),
        _compared(
            f"if [ -f {base} ]; then",
            f'  takagi design {base} --out {_OUT}/base || echo "the base is not proved"',
            "fi",
        ),
    ]


def _of_design(folder: Path, place: str, root: Path) -> tuple[list[Step], tuple[str, ...]]:
    """Return the steps that check a committed design, and a remark if its model is not named."""
    from takagi.reports.design_folder import CERTIFICATE, GAINS, RECORD, design_file

    design_file(folder, CERTIFICATE)
    own = shlex.quote(place)
    options = f"--gains {own}/{GAINS} " if (folder / GAINS).is_file() else ""
    model = None
    if (folder / RECORD).is_file():
        given = json.loads((folder / RECORD).read_text(encoding="utf-8")).get("given", "")
        model = next((f for f in (root / given, Path(given)) if f.suffix and f.is_file()), None)
    remarks: tuple[str, ...] = ()
    if model is not None and model.resolve().is_relative_to(root):
        options += f"--model {shlex.quote(model.resolve().relative_to(root).as_posix())} "
    else:
        remarks = ("the check has no --model: add the plant's file, so that it is compared too",)
    base = shlex.quote(f"{_BASE}/{place}")
    return [
        Step("check", (f"takagi check {own}/{CERTIFICATE} {options}{_REPORTS}",)),
        _compared(
            f"cp -r {own} {_OUT}/now",
            f"if [ -d {base} ]; then",
            f"  cp -r {base} {_OUT}/base",
            "fi",
        ),
    ], remarks


def _compared(*before: str) -> Step:
    """Return the comparison of the folders base and now, after the lines that make them."""
    page, summary = f"{_OUT}/comparison.html", f"{_OUT}/comparison.md"
    return Step(
        "compare",
        (
            *before,
            f"if [ -f {_OUT}/base/certificate.json ]; then",
            f"  takagi compare {_OUT}/base {_OUT}/now --tolerance 5% --html {page} "
            f"--summary {summary}",
            "else",
            f'  echo "The target branch has nothing to compare with." | tee {summary}',
            "fi",
        ),
    )


def _block(lines: tuple[str, ...], indent: int) -> Iterator[str]:
    """Yield the lines of a literal block of YAML."""
    return (" " * indent + line for line in lines)


def _head(place: str) -> list[str]:
    return [
        f"# Written by `takagi new {shlex.quote(place)} --ci`: proves the design at every change,",
        "# compares it with the target branch, and fails if it is not proved or got worse.",
    ]


def _github(steps: list[Step], place: str) -> str:
    """Return the steps as a workflow of GitHub Actions; later ones run after a failure too."""
    lines = [
        *_head(place),
        "name: takagi",
        "on:",
        "  push:",
        "    branches: [main, master]",
        "  pull_request:",
        "permissions:",
        "  contents: read",
        "  security-events: write",
        "env:",
        "  TARGET: ${{ github.base_ref || github.ref_name }}",
        "jobs:",
        "  takagi:",
        "    runs-on: ubuntu-latest",
        "    timeout-minutes: 30",
        "    steps:",
        "      - uses: actions/checkout@v4",
        "        with: { fetch-depth: 0 }",
        "      - uses: actions/setup-python@v5",
        '        with: { python-version: "3.12" }',
        "      - name: install",
        "        run: |",
        "          pip install takagi",
    ]
    summary = Step("summary", (f'cat {_OUT}/*.md >> "$GITHUB_STEP_SUMMARY"',))
    for k, step in enumerate([*steps, summary]):
        lines += [f"      - name: {step.name}", *["        if: always()"] * (k > 1)]
        lines += ["        run: |", *_block(step.lines, 10)]
    lines += [
        "      - if: always()",
        "        uses: actions/upload-artifact@v4",
        f"        with: {{ name: takagi, path: {_OUT} }}",
        "      # Needs code scanning, which private repositories may not have.",
        "      - if: always()",
        "        continue-on-error: true",
        "        uses: github/codeql-action/upload-sarif@v3",
        f"        with: {{ sarif_file: {_OUT}/checks.sarif }}",
    ]
    return "\n".join(lines) + "\n"


def _gitlab(steps: list[Step], place: str) -> str:
    """Return the steps as a job of GitLab CI; all are run, and the job fails if one did."""
    first, *others = steps
    lines = [
        *_head(place),
        "takagi:",
        "  image: python:3.12",
        "  timeout: 30 minutes",
        "  variables:",
        "    GIT_DEPTH: 0",
        "  rules:",
        '    - if: $CI_PIPELINE_SOURCE == "merge_request_event"',
        "    - if: $CI_COMMIT_BRANCH == $CI_DEFAULT_BRANCH",
        "  before_script:",
        "    - pip install takagi",
        "  script:",
        "    - |",
        '      TARGET="${CI_MERGE_REQUEST_TARGET_BRANCH_NAME:-$CI_COMMIT_BRANCH}"',
        *_block(first.lines, 6),
        "      FAILED=0",
    ]
    for step in others:
        lines += [f"      {{ # {step.name}", *_block(step.lines, 8), "      } || FAILED=1"]
    lines += [
        '      exit "$FAILED"',
        "  artifacts:",
        "    when: always",
        f"    paths: [{_OUT}]",
        "    reports:",
        f"      junit: {_OUT}/checks.xml",
    ]
    return "\n".join(lines) + "\n"
