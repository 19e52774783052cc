"""What if: other plans for a case, and other values of what is not known exactly, by the engine and a reduced flow."""
