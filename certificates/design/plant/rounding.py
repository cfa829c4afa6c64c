"""Gains as short decimals: each entry is rounded relative to its largest value over the rules."""

from __future__ import annotations

import numpy as np

from takagi.models.arrays import Floats


def rounded_gains(gains: Floats, digits: int) -> Floats:
    """Return the gains; each entry keeps ``digits`` digits of its largest value over the rules."""
    largest = np.abs(gains).max(axis=0)
    # An entry that is noise compared with its row has no effect on the command.
    floor = np.where(largest > 0, largest, 1.0)
    places = digits - 1 - np.floor(np.log10(floor)).astype(int)
    rounded = [
        [[round(float(v), int(p)) + 0.0 for v, p in zip(row, at, strict=True)]
         for row, at in zip(K, places, strict=True)]
        for K in gains
    ]  # fmt: skip
    return np.array(rounded)
