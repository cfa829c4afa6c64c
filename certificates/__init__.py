"""What may be claimed: the claims, their proof, and a checker that trusts nobody."""
