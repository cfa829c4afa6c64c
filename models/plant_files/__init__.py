"""Reading a plant file: from TOML entries to a Plant."""
