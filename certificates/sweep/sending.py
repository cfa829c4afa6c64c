"""Values as bytes for another process, with read-only mappings, which pickle does not support."""

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
    TypeError, AttributeError, pickle.PicklingError : a part of it cannot be sent.
    """
    buffer = io.BytesIO()
    _Sender(buffer, protocol=pickle.HIGHEST_PROTOCOL).dump(value)
    return buffer.getvalue()


def received(data: bytes) -> Any:
    """Return the value from the bytes that ``sent`` made in this or another process."""
    return pickle.loads(data)


class _Sender(pickle.Pickler):
    """A pickler that sends a read-only mapping as a copy of the mapping behind it."""

    dispatch_table = copyreg.dispatch_table.copy()


def _proxy(shown: dict[Any, Any]) -> Mapping[Any, Any]:
    return MappingProxyType(shown)


def _reduced(proxy: Mapping[Any, Any]) -> tuple[Any, tuple[dict[Any, Any]]]:
    return _proxy, (dict(proxy),)


_Sender.dispatch_table[MappingProxyType] = _reduced
