"""Signal names that python-control can hold: words without units."""

from __future__ import annotations

import re
from collections.abc import Iterable


def signal_names(labels: Iterable[str]) -> list[str]:
    """Return labels such as ``rotor speed [rad/s]`` as ``rotor_speed``.

    python-control has a meaning for a dot in a name, and none for units.
    """
    return [re.sub(r"\W+", "_", label.split(" [")[0]).strip("_") for label in labels]
