"""Plants in the checker: equations as text, their identities and ranges; claims about them."""
