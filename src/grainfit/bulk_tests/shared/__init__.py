"""Parts that several bulk tests share."""
