"""Facts of a patient that several parts share: types of plaque, blood pressure, the states of a case.

May import: common.
"""
