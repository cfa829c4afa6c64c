"""What a gain file has to say of the law that a certificate proves: texts, units, programs."""
