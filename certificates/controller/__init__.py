"""What a gain file says beside the law: made for a design, or read from a file that exists."""
