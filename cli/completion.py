"""Completion by the shell: verbs, their options, and names of models, studies and topics.

typer writes the shell's script and answers it. It is given the options of the verb on the line
alone, read from the verb's help, so that no other verb is imported.
"""

from __future__ import annotations

import inspect
import io
import os
import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import redirect_stdout
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from takagi.cli.main import Verb

_OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")


def complete(arguments: Sequence[str], verbs: Iterable[Verb]) -> int:
    """Answer the shell, or install or show its script; return the exit status."""
    # The line so far: bash has it in the first variable, the other shells in the second.
    line = os.environ.get("COMP_WORDS") or os.environ.get("_TYPER_COMPLETE_ARGS", "")
    words = line.split()[1:]
    application = typer.Typer(rich_markup_mode=None, pretty_exceptions_enable=False)
    for verb in verbs:
        help_words = words if words[:1] == [verb.name] else None
        application.command(verb.name, help=verb.help)(_described(help_words))
    try:
        application(args=list(arguments), prog_name="takagi")
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    return 0


def _described(words: Sequence[str] | None) -> Callable[..., None]:
    """Return a command with the options of the verb that begins the words; none without words."""

    def command(**_: object) -> None:
        """Complete a line; nothing is run."""

    names: tuple[str, ...] = ()
    parameters = []
    annotated: Any = Annotated
    if words:
        text = _help_of(words)
        names = _names_of(words[0], text)
        # As flags: what follows an option is completed like any other word.
        for option in dict.fromkeys(_OPTION.findall(text)):
            parameters.append(_parameter(option[2:], annotated[bool, typer.Option(option)], False))
    listed = typer.Argument(
        autocompletion=lambda incomplete: [n for n in names if n.startswith(incomplete)]
    )
    parameters.append(_parameter("words", annotated[list[str] | None, listed], None))
    described: Any = command
    described.__signature__ = inspect.Signature(parameters)
    described.__annotations__ = {p.name: p.annotation for p in parameters}
    return command


def _parameter(name: str, annotation: Any, default: object) -> inspect.Parameter:
    kind = inspect.Parameter.KEYWORD_ONLY
    return inspect.Parameter(
        f"_{name.replace('-', '_')}", kind, default=default, annotation=annotation
    )


def _help_of(words: Sequence[str]) -> str:
    """Return the help of a verb; of a study that is named, that of the study."""
    study = [word for word in words[1:2] if words[0] == "study" and word in _studies()]
    text = io.StringIO()
    with redirect_stdout(text):
        import_module(f"takagi.cli.verbs.{words[0]}").run([*study, "--help"])
    return text.getvalue()


def _names_of(verb: str, text: str) -> tuple[str, ...]:
    """Return the words that a verb's first argument may be, beside files."""
    if verb == "help":
        from takagi.cli.verbs.help import topics

        return tuple(topics())
    if verb == "study" and "NAME" in text:
        return _studies()
    if "{MODEL}" in text:
        from takagi.models.files.library import data_folder

        return tuple(sorted(file.stem for file in data_folder().glob("*.toml")))
    return ()


def _studies() -> tuple[str, ...]:
    from takagi.cli.verbs.study import STUDIES

    return tuple(study.name for study in STUDIES)
