"""`takagi explore`: a page on this machine on which a plant's requirements are turned."""
