"""Gains against disturbances: energy gain (H-infinity), variance (H2), peak-to-peak.

disturbed_plant   plant, disturbance and performance output
*_sums            the LMIs of one norm as double sums;  *_design  gains with the least norm
task, units, sums, design    what the norms share: checked at the door, posed in good units, solved
"""
