"""The zoo: small axes that several tests declare alike.

`bodies` has one body and its friction, with what a test adds to it; `simulated` the axes that put
the simulation to the test; `unseen` the paper's axis with a term that its motion hardly shows. An
axis that shows what one test file is about is declared there.
"""
