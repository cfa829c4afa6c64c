"""A certificate's matrices as theorems for the proof assistant Coq (Rocq)."""
