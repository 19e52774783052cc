"""Other plans and other inputs of a case: reads the tables of `whatif`, draws them, and prepares them for the page."""
