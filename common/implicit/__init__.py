"""Tubular surfaces as implicit fields, and triangle meshes of a field's zero level."""
