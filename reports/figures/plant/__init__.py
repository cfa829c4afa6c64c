"""The figures of a plant's design."""
