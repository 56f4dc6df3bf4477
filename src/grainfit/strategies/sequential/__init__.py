"""Sequential strategy: every run goes where it is expected to improve the answer most."""
