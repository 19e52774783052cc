"""Table of the patients, and which of them meet the study's criterion of inclusion."""
