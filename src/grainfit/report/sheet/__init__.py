"""The customer's sheet: a calibrated material on two pages, as PDF."""
