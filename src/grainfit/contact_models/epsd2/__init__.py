"""EPSD2: rolling resistance by an elastic-plastic spring, without dashpot."""
