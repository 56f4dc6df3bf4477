"""EPSD: rolling resistance by an elastic-plastic spring and a dashpot."""
