"""Controller laws as values: the protocol that they share, and the laws."""
