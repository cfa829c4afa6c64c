"""Why there was no answer, and what would help, measured.

explanation            the explanation as a value, in words
weaker_requests        repeated design with weaker requests
smaller_box            the model on a smaller box
uncontrollable_blend   a blend that no gains stabilise
"""
