"""Whether a certificate is about the files that are given beside it: gains, turbine, plant."""
