"""Tubular surfaces as implicit fields, and the triangles that a field's zero level is meshed by."""
