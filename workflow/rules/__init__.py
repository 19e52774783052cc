"""The rules of the study, and what their steps ask a cluster for."""
