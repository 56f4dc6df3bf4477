"""The page on which what was found on a photograph is corrected by hand."""
