"""The `takagi` command: finds the verb in its table and imports only its module."""

from __future__ import annotations

import atexit
import gc
import os
import sys
import tomllib
from collections.abc import Sequence
from importlib import import_module
from importlib.resources import files
from typing import NamedTuple

from takagi.cli.command import MISUSE, guard


class Verb(NamedTuple):
    """A verb of the command line; its module ``verbs.<name>`` has ``run(arguments) -> int``."""

    name: str
    help: str  # one line, without a full stop
    example: str = ""  # what `takagi --help` shows under "First steps", without the word takagi


_TEXTS = tomllib.loads(files("takagi.cli").joinpath("main.toml").read_text(encoding="utf-8"))
VERBS = tuple(
    Verb(name, words["line"], words.get("example", "")) for name, words in _TEXTS["verbs"].items()
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run ``takagi`` with the given arguments (default: the command line's); return its status.

    0: everything asked is proved and passes.  1: something is not.  2: misuse.
    130: interrupted.  70: an error in takagi itself.
    """
    _escape_what_cannot_be_shown()
    # The matrices are small. On a busy machine a second thread of the linear algebra makes a
    # solution of three equations a thousand times as expensive.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    words = list(sys.argv[1:] if arguments is None else arguments)
    return guard(lambda: _dispatch(words), as_json="--json" in words)


def _escape_what_cannot_be_shown() -> None:
    """Make outputs escape characters that their encoding lacks, instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        # What a caller has put in the place of an output may have no encoding.
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure is not None:
            reconfigure(errors="backslashreplace")


def _complete(arguments: list[str]) -> int:
    # Imported here: nothing else needs typer before a verb is known.
    status: int = import_module("takagi.cli.completion").complete(arguments, VERBS)
    return status


def _dispatch(arguments: list[str]) -> int:
    if "_TAKAGI_COMPLETE" in os.environ:
        return _complete(arguments)
    if not arguments:
        print(_help(), end="", file=sys.stderr)
        return MISUSE
    first, following = arguments[0], arguments[1:]
    if first in ("--help", "-h"):
        print(_help(), end="")
        return 0
    if first == "--version":
        # Imported here: reading the distribution's metadata takes longer than the whole of --help.
        from importlib.metadata import version

        print(f"takagi {version('takagi')}")
        return 0
    if first in ("--install-completion", "--show-completion"):
        return _complete(arguments)
    for verb in VERBS:
        if verb.name == first:
            empty = _empty(following)
            if empty:
                print(empty, file=sys.stderr)
                return MISUSE
            # Garbage in cycles is looked for at every 700th new object, and once more among all
            # libraries at the end: with the end a fifth of a small design.
            gc.set_threshold(50_000)
            atexit.register(gc.freeze)
            status: int = import_module(f"takagi.cli.verbs.{verb.name}").run(following)
            return status
    print(_unknown(first), file=sys.stderr)
    return MISUSE


def _help() -> str:
    width = max(len(verb.name) for verb in VERBS)
    verbs = [f"  {verb.name:<{width}}  {verb.help}" for verb in VERBS]
    steps = [f"  takagi {verb.example}" for verb in VERBS if verb.example]
    return "\n".join(
        [
            _TEXTS["introduction"],
            "Verbs:",
            *verbs,
            "",
            "First steps:",
            *steps,
            "",
            _TEXTS["closing"],
        ]
    )


def _unknown(word: str) -> str:
    # Imported here because only a mistyped verb needs it.
    from takagi.models.errors import did_you_mean

    kind = "option" if word.startswith("-") else "verb"
    options = ["--help", "--version", "--install-completion", "--show-completion"]
    names = options if kind == "option" else [verb.name for verb in VERBS]
    return (
        f"Error: {kind} {word!r} is not known{did_you_mean(word, names)}\n"
        f"Known: {', '.join(names)}; `takagi --help` explains them."
    )


def _empty(arguments: Sequence[str]) -> str:
    """Return the message for an empty text, which would otherwise mean the current folder."""
    for k, text in enumerate(arguments):
        option, equals, value = text.partition("=")
        if text and (value or not equals or not option.startswith("--")):
            continue
        option_name = option or (arguments[k - 1] if k and arguments[k - 1].startswith("-") else "")
        where = f" for {option_name}" if option_name else f" as argument {k + 1}"
        return (
            f"Error: an empty text was given{where}; write what is needed ('.' is the current "
            f"folder){', or leave the option out' if option_name else ''}"
        )
    return ""
