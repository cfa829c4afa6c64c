"""Expressions as text, by a grammar that executes nothing."""
