"""Virtual patients with a known truth, and the post-PCI lumen that the method did not make."""
