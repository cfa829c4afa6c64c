"""The certificate file and its members: model, law and claims as short decimals."""
