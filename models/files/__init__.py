"""What model files have in common.

TOML with file, line and field in messages, units, tables from CSV, and the built-in models by
name.
"""
