"""What users choose by name, a row for each: methods of estimation, covariances of the residuals.

In: nothing. Out: rows that say where it lives, from which `axisid.estimation.methods` has it.
Knows nothing of how anything is computed, so that help and completion load no stage. Its modules
are imported by name.
"""
