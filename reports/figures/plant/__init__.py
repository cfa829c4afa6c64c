"""The figures of a plant's design.

weights        premises and their weights over the box
poles          poles of vertices and plant, with the proved decay rate
responses      motions over time
proved_set     the proved set in the plane of every pair of states
phase_plane    motions in planes of two states, with box and ellipsoid
blend          two actuators behind a blend
captioned      all of them with captions, and their data as CSV
"""
