"""Takagi-Sugeno models, LMI design and exact certificates: the folders are takagi.<folder>."""

from __future__ import annotations


def __getattr__(name: str) -> str:
    """Return the release as ``__version__``, read where it is asked for."""
    if name == "__version__":
        # Imported here: the distribution's metadata takes longer to read than `takagi --help`.
        from importlib.metadata import version

        return version("takagi")
    raise AttributeError(f"module 'takagi' has no attribute {name!r}")
