"""The sequential strategy: every run where it is expected to improve the answer most."""
