"""Work that several verbs share: making designs, and reading earlier certificates."""
