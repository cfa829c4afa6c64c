"""Runs a typer command as a verb: every exception becomes one clear message and an exit status."""

from __future__ import annotations

import contextlib
import inspect
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any

from takagi.cli.texts import verb_text

PROVED = 0  # everything asked is proved and passes
UNPROVED = 1  # something is DISPROVED, UNDECIDED, or below its threshold
MISUSE = 2  # what was asked makes no sense, or a file cannot be read or written
INTERNAL = 70  # EX_SOFTWARE of sysexits.h: an error in takagi, never the user's
INTERRUPTED = 130  # 128 + SIGINT, as shells do
_BROKEN_PIPE = 141  # 128 + SIGPIPE


def guard(work: Callable[[], int], *, as_json: bool = False) -> int:
    """Return the exit status of ``work``, or print why it failed and return the failure's status.

    With ``as_json`` the reason is also an object on standard output: ``error`` and ``status``.

    Errors of takagi's own types carry a text written for the user, which is printed as it is.
    Anything unforeseen is one line that asks for a report; ``TAKAGI_DEBUG=1`` adds the traceback.
    """
    try:
        status = work()
        # A full disk or a closed pipe shows only when the buffer is written: do it here, where
        # the failure can still be told, not at the interpreter's exit.
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:
        print("\nInterrupted.", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:
        _abandon_output()
        return _BROKEN_PIPE
    except Exception as error:
        if os.environ.get("TAKAGI_DEBUG") == "1":
            import traceback

            traceback.print_exception(error)
        message, status = _explain(error)
        tell_error(message, status, as_json=as_json)
        return status


def tell_error(message: str, status: int, *, as_json: bool) -> None:
    """Print an error on standard error, and for machines on standard output too."""
    print(f"Error: {message}", file=sys.stderr)
    if as_json:
        import json

        print(json.dumps({"error": message, "status": status}, indent=2))


def _explain(error: Exception) -> tuple[str, int]:
    # ModelError, CertificateError and similar types are recognised by their module: importing them
    # here would import their packages.
    if isinstance(error, ValueError | OSError) and type(error).__module__.startswith("takagi."):
        return str(error), MISUSE
    if isinstance(error, OSError):
        # Imported here because most runs meet no such error.
        from takagi.reports.output import explain

        return explain(error), MISUSE
    if isinstance(error, UnicodeDecodeError):
        return f"a file is not UTF-8 text (byte {error.start}: {error.reason}); save it so", MISUSE
    if isinstance(error, MemoryError):
        return "memory is used up; ask for less at once, or use a larger machine", MISUSE
    text = " ".join(str(error).split())
    return (
        f"internal error ({type(error).__name__}: {text}); this is a fault of takagi, please "
        "report it with the command line. TAKAGI_DEBUG=1 shows the traceback.",
        INTERNAL,
    )


def _abandon_output() -> None:
    # The reader of the pipe is gone (`takagi ... | head`); without this the interpreter would
    # complain once more when it flushes at exit.  An output that is no real file needs nothing.
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def run_command(
    name: str,
    function: Callable[..., int],
    arguments: Sequence[str],
    *,
    options: Sequence[inspect.Parameter] = (),
    listed: str = "",
) -> int:
    """Parse ``arguments`` by the signature of ``function``, call it, return its exit status.

    The help is ``verb_text``, or the docstring of ``function``; ``--all-options`` explains all
    grouped options too.  Misuse prints the usage and returns 2.

    listed : what stands in the text for "{listed}".
    options : that several verbs share; the ``**options`` of ``function`` take them, and they stand
        in the help before its keyword-only parameters.
    """
    # Imported here: `takagi --help` and `takagi check` do without typer.
    import typer

    from takagi.cli.grouped_help import EVERY, GroupedCommand

    signature = _joined(name, function, options)

    def command(**values: object) -> None:
        # The error handling is inside typer, which would handle interrupts and pipes in its own
        # way.
        raise typer.Exit(guard(lambda: function(**values), as_json=bool(values.get("as_json"))))

    # typer reads the parameters from here.
    described: Any = command
    text = verb_text(name) or function.__doc__ or ""
    described.__name__, described.__doc__ = function.__name__, text.replace("{listed}", listed)
    described.__signature__ = signature
    described.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
    application = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,  # plain text, the same in `check`, which does without typer
        pretty_exceptions_enable=False,
        context_settings={
            "help_option_names": ["-h", "--help"],
            "max_content_width": 100,
            "obj": EVERY in arguments,
        },
    )
    application.command(name, cls=GroupedCommand)(command)
    if EVERY in arguments:
        arguments = ["--help"]
    as_json = "--json" in arguments
    try:
        status = application(
            args=list(arguments), prog_name=f"takagi {name}", standalone_mode=not as_json
        )
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except Exception as error:
        # What typer says of an option that it cannot read.
        message = getattr(error, "format_message", None)
        if message is None:
            raise
        tell_error(message(), MISUSE, as_json=True)
        return MISUSE
    return status if isinstance(status, int) else 0


def _joined(
    name: str, function: Callable[..., int], options: Sequence[inspect.Parameter]
) -> inspect.Signature:
    """Return the parameters of the function with the options, all by keyword."""
    from takagi.cli.options.given import with_words

    stated = inspect.signature(function, eval_str=True).parameters.values()
    parameters = [p if p.kind is p.VAR_KEYWORD else with_words(name, p) for p in stated]
    first = [p for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD]
    last = [p for p in parameters if p.kind is p.KEYWORD_ONLY]
    return inspect.Signature([p.replace(kind=p.KEYWORD_ONLY) for p in (*first, *options, *last)])
