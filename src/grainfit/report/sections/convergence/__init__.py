"""Section of the report: convergence."""
