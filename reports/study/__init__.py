"""All cases together: agreement, the cohort's table, timings, software, and the published agreement.

It builds on inputs and measuring.
"""
