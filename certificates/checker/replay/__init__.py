"""The whole check of one file: its hashes, the files given beside it, and each claim."""
