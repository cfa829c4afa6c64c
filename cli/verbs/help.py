"""`takagi help`: a verb's help, or a screen of text about a subject; the texts are `help.toml`."""

from __future__ import annotations

import tomllib
from functools import partial
from importlib import import_module
from importlib.resources import files
from typing import Annotated

import typer

from takagi.cli.command import PROVED, run_command
from takagi.cli.main import VERBS
from takagi.models.errors import ModelError, did_you_mean

SUBJECTS: dict[str, dict[str, str]] = tomllib.loads(
    files("takagi.cli.verbs").joinpath("help.toml").read_text(encoding="utf-8")
)


def explain(
    topic: Annotated[
        list[str] | None, typer.Argument(metavar="[TOPIC]", help="A verb or a subject.")
    ] = None,
) -> int:
    """Explain a verb or a subject; without one, list all."""
    if not topic:
        print(_listed())
        return PROVED
    first, *following = topic
    if first in (verb.name for verb in VERBS):
        # Of `takagi help study overlap` the verb reads the second word.
        status: int = import_module(f"takagi.cli.verbs.{first}").run([*following, "--help"])
        return status
    name = " ".join(topic)
    subject = SUBJECTS.get(name.lower())
    if subject is None:
        known = topics()
        raise ModelError(
            f"topic {name!r} is not known{did_you_mean(name, known)}; `takagi help` lists all"
        )
    print(f"{subject['about']}\n\n{subject['text']}\nRead {subject['page']}.")
    return PROVED


run = partial(run_command, "help", explain)


def topics() -> list[str]:
    """Return the names of all subjects and verbs."""
    return [*SUBJECTS, *(verb.name for verb in VERBS)]


def _listed() -> str:
    width = max(map(len, topics()))
    subjects = [f"  {name:<{width}}  {subject['about']}" for name, subject in SUBJECTS.items()]
    verbs = [f"  {verb.name:<{width}}  {verb.help}" for verb in VERBS]
    return "\n".join(
        ["Subjects:", *subjects, "", "Verbs:", *verbs, "", "`takagi help TOPIC` explains one."]
    )
