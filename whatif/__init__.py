"""What if: other plans for a case, and other values of its uncertain inputs, by the engine and a reduced flow."""
