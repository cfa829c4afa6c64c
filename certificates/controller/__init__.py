"""The members of a gain file other than the law."""
