"""All cases together: one module for each table, such as agreement, cohort, timings, seconds and subgroups.

`nearer` tells over all cases which of VCI and radius correction is nearer to the truth, `contrast` tells it for each.
`differences` has Diff^A and Diff^C of the source.

The folder also has the statistics of Bland and Altman, the criterion of inclusion, the published agreement and the
versions of the software. `tables` reads the tables back.

May import: common.*, reports.inputs, reports.measuring.
"""
