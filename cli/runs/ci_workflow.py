"""The workflow of continuous integration for a plant's file or a committed design.

Its steps are shell commands, the same for GitHub and GitLab: the base, from the branch that a
change goes to; a design, or the committed one; its check; the comparison of both.  They stand in
``ci_steps.jinja``, and each service has a template.
"""

from __future__ import annotations

import json
import os
import shlex
from pathlib import Path
from typing import NamedTuple

from takagi.models.errors import ModelError

# Kind of service -> the file that it reads, relative to the repository's folder.
FILES = {"github": ".github/workflows/takagi.yml", "gitlab": ".gitlab-ci.yml"}


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
    import jinja2

    if service not in FILES:
        raise ModelError(f"--ci {service}: is not known; {' or '.join(FILES)} is needed")
    here = Path.cwd().resolve()
    # The folder of the git repository, or the current one outside of any.
    root = next((f for f in (here, *here.parents) if (f / ".git").exists()), here)
    try:
        place = subject.resolve().relative_to(root).as_posix()
    except ValueError:
        raise ModelError(
            f"{subject}: lies outside of the repository {root}; run the command in the repository "
            "of the plant"
        ) from None
    quoted = shlex.quote(place)
    remarks: tuple[str, ...] = ()
    if subject.is_dir():
        steps = ["check", "compare"]
        checked, remarks = _committed_design(subject, quoted, root)
    else:
        from takagi.models.loading import load_model

        # A file that `takagi design` would refuse has no use in a workflow.
        load_model(subject)
        steps = ["design", "check", "compare"]
        checked = f"takagi-ci/now --model {quoted}"
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("takagi.cli.runs", ""), trim_blocks=True, lstrip_blocks=True,
        undefined=jinja2.StrictUndefined, keep_trailing_newline=True,
    )  # fmt: skip
    text = environment.get_template(f"ci_{service}.jinja").render(
        steps=steps,
        subject=quoted,
        base_subject=shlex.quote(f"takagi-base/{place}"),
        checked=checked,
        is_design=subject.is_dir(),
    )
    return Workflow(Path(os.path.relpath(root / FILES[service])), text, remarks)


def _committed_design(folder: Path, quoted: str, root: Path) -> tuple[str, tuple[str, ...]]:
    """Return what the check of a committed design is given, and a remark if it has no model."""
    from takagi.reports.design_folder import CERTIFICATE, GAINS, RECORD, design_file

    design_file(folder, CERTIFICATE)
    checked = f"{quoted}/{CERTIFICATE}"
    if (folder / GAINS).is_file():
        checked += f" --gains {quoted}/{GAINS}"
    model = None
    if (folder / RECORD).is_file():
        given = json.loads((folder / RECORD).read_text(encoding="utf-8")).get("given", "")
        model = next((f for f in (root / given, Path(given)) if f.suffix and f.is_file()), None)
    if model is not None and model.resolve().is_relative_to(root):
        model_path = shlex.quote(model.resolve().relative_to(root).as_posix())
        return f"{checked} --model {model_path}", ()
    remark = "the check has no --model: add the plant's file, so that it is compared too"
    return checked, (remark,)
