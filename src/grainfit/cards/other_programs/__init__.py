"""Cards for programs that grainfit does not run, one module for each."""
