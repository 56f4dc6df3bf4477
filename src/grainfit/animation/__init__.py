"""Animation of a run: its frames in three dimensions, with the walls where they are."""
