"""Gains against disturbances: energy gain (H-infinity), variance (H2), peak-to-peak.

disturbed_plant      plant, disturbance and performance output
energy_gain, output_variance, peak_gain    gains with the least norm, and its LMIs
request, coordinates, sums, design    what the norms share: checked on entry, posed in good
                     coordinates, solved
riccati_bound        the least H2 norm of one rule, by two other ways
"""
