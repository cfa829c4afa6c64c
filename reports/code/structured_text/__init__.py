"""IEC 61131-3 Structured Text: a function block with its gains as constants."""
