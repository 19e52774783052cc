"""Who the patients are, and which of them meet the study's criterion of inclusion."""
