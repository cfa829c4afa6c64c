"""What any gain design may be asked to keep, as double sums or LMIs."""
