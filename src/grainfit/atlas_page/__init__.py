"""The page of the atlas: what every input does to every response, in the browser."""
