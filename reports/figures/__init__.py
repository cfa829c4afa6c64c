"""Figures of the reports: each takes plain arrays and returns a matplotlib ``Figure``."""
