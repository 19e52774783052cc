"""Virtual patients with a known truth, and their lumen after PCI by an independent method."""
