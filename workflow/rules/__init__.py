"""The rules of the study, and the resources that their steps request from a cluster.

May import: no other folder.
"""
