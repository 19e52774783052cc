"""All cases together: tables of agreement, nearer, contrast, differences, cohort, timings, seconds and subgroups.

Beside them: the statistics of Bland and Altman, the criterion of inclusion, the published agreement, the versions of
the software, and `tables`, which reads the tables back. The folder builds on inputs and measuring.
"""
