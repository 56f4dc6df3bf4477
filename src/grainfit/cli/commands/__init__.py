"""The commands, a file for each: `grainfit.cli.app` mounts them."""
