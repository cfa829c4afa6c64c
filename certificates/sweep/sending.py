"""Values as bytes for another process, read-only mappings in them, which pickle does not know."""

from __future__ import annotations

import copyreg
import io
import pickle
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any


def sent(value: object) -> bytes:
    """Return the value as bytes.

    Raises
    ------
    TypeError, AttributeError, pickle.PicklingError : something in it cannot be sent.
    """
    buffer = io.BytesIO()
    _Sender(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(value)
    return buffer.getvalue()


def received(data: bytes) -> Any:
    """Return the value that ``sent`` made the bytes of, in this or another process."""
    return pickle.loads(data)


class _Sender(pickle.Pickler):
    """A pickler that sends a read-only mapping as what it shows."""

    dispatch_table = copyreg.dispatch_table.copy()


def _proxy(shown: dict[Any, Any]) -> Mapping[Any, Any]:
    return MappingProxyType(shown)


def _reduced(proxy: Mapping[Any, Any]) -> tuple[Any, tuple[dict[Any, Any]]]:
    return _proxy, (dict(proxy),)


_Sender.dispatch_table[MappingProxyType] = _reduced
