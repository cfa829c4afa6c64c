"""Why there was no answer, and what would help, measured.

explanation            the value that says so in words
weaker_requests        asking again with less
smaller_box            the model on a smaller box
uncontrollable_blend   a blend that no gains can help
"""
