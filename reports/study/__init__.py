"""All cases together: tables of agreement, nearer, contrast, differences, cohort, timings, seconds and subgroups.

The folder also has the statistics of Bland and Altman, the criterion of inclusion, the published agreement and the
versions of the software. `tables` reads the tables back. The folder imports from inputs and measuring.
"""
