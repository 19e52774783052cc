"""Other plans and other inputs of a case: tables of `whatif` read, drawn and put into words."""
