"""Options: declared once with kind, limits, default and help; read with every fault named."""
