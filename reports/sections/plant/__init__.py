"""The HTML report of a plant's design, one section a file."""
