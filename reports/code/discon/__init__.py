"""`takagi export --to discon`: the law as a library with the Bladed-style interface."""
