"""One verb of the command line a file, of the verb's name."""
