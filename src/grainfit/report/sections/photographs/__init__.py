"""Section of the report: photographs beside simulated heaps."""
