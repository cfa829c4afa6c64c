"""Reading a plant file.

TOML entries to a Plant, with its tables, its blend and its design settings.
"""
