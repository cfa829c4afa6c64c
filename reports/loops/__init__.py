"""A design's loops as numbers, read by sections, figures and appendix."""
