"""Error handling: every exception becomes one clear message and an exit status."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Callable

PROVED = 0  # everything asked is proved and passes
UNPROVED = 1  # something is DISPROVED, UNDECIDED, or below its threshold
MISUSE = 2  # what was asked makes no sense, or a file cannot be read or written
INTERNAL = 70  # EX_SOFTWARE of sysexits.h: an error in takagi, never the user's
INTERRUPTED = 130  # 128 + SIGINT, as shells do
_BROKEN_PIPE = 141  # 128 + SIGPIPE


def guard(work: Callable[[], int]) -> int:
    """Return the exit status of ``work``, or print why it failed and return the failure's status.

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
        print(f"Error: {message}", file=sys.stderr)
        return status


def _explain(error: Exception) -> tuple[str, int]:
    # ModelError, CertificateError and similar types are recognised by their module: importing them
    # here would import their packages.
    if isinstance(error, ValueError | OSError) and _is_ours(error):
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


def _is_ours(error: Exception) -> bool:
    return type(error).__module__.split(".", 1)[0] == "takagi"


def _abandon_output() -> None:
    # The reader of the pipe is gone (`takagi ... | head`); without this the interpreter would
    # complain once more when it flushes at exit.  An output that is no real file needs nothing.
    with contextlib.suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
