"""Page, data and figure of a sweep (``maps``), and of campaigns of random runs (``campaigns``)."""
