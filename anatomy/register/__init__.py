"""The lumen found after a real procedure, brought to the one before it by a rigid registration of their axes."""
