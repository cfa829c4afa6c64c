"""The law of a gain file as code that other tools run; every number is a decimal of the file."""
