"""Pages that are served on this machine alone, to whoever has their address."""
