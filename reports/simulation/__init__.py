"""`takagi simulate`: laws side by side in the same winds, as a table, figures and series."""
