"""The built-in models as files: one TOML a model, and the tables that it names."""
