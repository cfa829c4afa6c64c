"""Studies: laws of one turbine in many winds, with what is proved of them."""
