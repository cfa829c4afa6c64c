"""The gain file ``gains.json``: one envelope, two bodies."""
