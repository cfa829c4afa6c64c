"""From a condition to an answer that passes an independent check."""
