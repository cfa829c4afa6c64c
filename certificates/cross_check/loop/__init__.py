"""The second checker's claims about the loop of model and gains.

loop         vertices, gains, mixtures whose convex hull contains the loop; pieces of the weights
decay        decay, its absence, regions of poles, overshoot
fuzzy        decay and energy gain with a function that the weights schedule
disturbed    invariant sets, energy and peak gains, leaving a set under white noise
limits       bounds of the inputs and of their rates
observing    an observer's error, and the loop through it
sampled      a law whose command is held between samples
"""
