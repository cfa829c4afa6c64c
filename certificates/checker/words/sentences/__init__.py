"""The sentence of a proved or refused claim, one kind a file, made after the verdict is known."""
