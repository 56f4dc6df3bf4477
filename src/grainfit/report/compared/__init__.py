"""Page of calibrations side by side."""
