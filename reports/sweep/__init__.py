"""Page, data and figure of a sweep, and of campaigns of random runs."""
