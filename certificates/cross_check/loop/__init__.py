"""The second checker's claims about the loop that model and gains make.

loop         vertices, gains, and what the loop is a mixture of
pieces       a loop on pieces of its weights
decay        decay, its absence, regions of poles, overshoot
fuzzy        decay with a function that the weights schedule
disturbed    sets that nothing leaves, gains of energy and of peaks
limits       how large the inputs get, and how fast they move
observing    an observer's error, and the loop through it
"""
