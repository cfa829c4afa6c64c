"""Interval arithmetic and best-first search over boxes: what proved ranges are computed with."""
