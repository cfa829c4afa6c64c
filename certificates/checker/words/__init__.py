"""Numbers of a verdict in words, rounded to the side on which the sentence stays true."""
