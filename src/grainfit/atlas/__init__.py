"""The atlas: runs of the bulk tests in natural units, which answer before any simulation."""
