"""The store of runs and calibrations, alone or shared by several processes."""
