"""Existing gains: the law of a gain file is read, to certify it or to run it."""
