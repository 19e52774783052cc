"""The study's report: one HTML file that holds all it shows and fetches nothing."""
