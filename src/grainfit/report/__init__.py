"""The report: one page that answers whether it is calibrated, what the numbers are, how sure."""
