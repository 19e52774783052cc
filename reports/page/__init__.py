"""The study's report: one HTML file that holds all its content and fetches nothing."""
