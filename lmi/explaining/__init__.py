"""Why there was no answer, and what would help, measured.

explanation   the value that says so in words;  cures  asking again with less
smaller_box, stuck_blend    the model on a smaller box; a blend that no gains can help
"""
