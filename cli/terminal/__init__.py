"""The texts that verbs print on the terminal."""
