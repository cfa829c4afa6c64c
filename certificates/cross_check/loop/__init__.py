"""The second checker's claims about the loop of model and gains.

loop         vertices, gains, and the mixtures whose convex hull contains the loop
pieces       the loop on parts of the set of its weights
decay        decay, its absence, regions of poles, overshoot
fuzzy        decay with a function that the weights schedule
disturbed    invariant sets, energy and peak gains
limits       bounds of the inputs and of their rates
observing    an observer's error, and the loop through it
"""
