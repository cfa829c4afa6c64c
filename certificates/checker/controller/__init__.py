"""The contents of the gain file of a proved law: texts, units, programs."""
