"""Multisets of small integers, as many at once: enumerated, numbered, counted."""

from __future__ import annotations

from math import comb

import numpy as np

from takagi.models.arrays import Indices


def count_of(values: int, degree: int) -> int:
    """Return how many multisets of ``degree`` numbers from 0 ... values - 1 there are."""
    return comb(values + degree - 1, degree)


def multisets(values: int, degree: int) -> Indices:
    """Return (count, degree), each row sorted; row k is the multiset with number k."""
    found = np.zeros((1, 0), dtype=np.intp)
    for _ in range(degree):
        # Each row is continued with every value from its last entry to the largest one.
        last = found[:, -1] if found.shape[1] else np.zeros(len(found), dtype=np.intp)
        choices = values - last
        row = np.repeat(np.arange(len(found)), choices)
        step = np.arange(len(row)) - np.repeat(np.cumsum(choices) - choices, choices)
        found = np.column_stack([found[row], last[row] + step])
    ordered = np.empty_like(found)
    ordered[numbers_of(found, values)] = found
    return ordered


def numbers_of(rows: Indices, values: int) -> Indices:
    """Return the numbers, 0 ... count - 1, of multisets given as sorted rows, (..., degree).

    m_1 <= m_2 <= ... becomes c_t = m_t + t - 1, a set; sets are numbered by sum_t (c_t choose t).
    """
    degree = rows.shape[-1]
    table = np.array(
        [[comb(c, t + 1) for t in range(degree)] for c in range(values + degree)], dtype=np.intp
    ).reshape(values + degree, degree)
    place = np.arange(degree)
    return np.asarray(table[rows + place, place].sum(axis=-1), dtype=np.intp)
